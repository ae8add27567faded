"""Octree frames: the root unasked, then what is wanted, most wanted first; labels by chunk."""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest

from pointbrush.labels import effect
from pointbrush.sequences import importer
from tests.serving import Served, add_sequence, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer

POINTS = 300_000


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    settings = settings_in(tmp_path_factory.mktemp("large"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(importer, "LARGE_POINTS", 50_000)
        add_sequence(settings, "scan", frames=1, points=POINTS)
    with serving(settings) as running:
        running.workspace.labels.create_label("scan", "somebody", name="pin")
        yield running


def table_of(scan: Served) -> list[dict[str, Any]]:
    url = f"{scan.url}/api/v1/sequences/scan/frames/0/chunks"
    chunks: list[dict[str, Any]] = httpx.get(url, headers=scan.headers).json()["chunks"]
    return chunks


async def receive_chunks(client: Viewer, count: int) -> list[int]:
    """Numbers of the chunks that came, in order, once ``count`` are here."""
    while 0 not in client.frames or len(client.frames[0].chunks) < count:
        await client.receive()
    return [chunk["index"] for chunk in client.frames[0].chunks]


def test_the_root_comes_unasked_and_the_rest_as_wanted(scan: Served) -> None:
    table = table_of(scan)
    assert len(table) > 4

    async def scenario() -> None:
        async with viewer(scan.url, scan.token) as client:
            info = await client.open("scan")
            assert info["large"]
            roots = [chunk["index"] for chunk in table if chunk["level"] == table[0]["level"]]
            assert await receive_chunks(client, len(roots)) == roots
            rest = [chunk["index"] for chunk in table if chunk["index"] not in roots]
            wanted = [*rest[::-1], 10**6]
            await client.send(type="want", frame=0, chunks=wanted)
            came = await receive_chunks(client, len(table))
            assert sorted(came) == list(range(len(table)))
            assert came[len(roots)] == rest[-1], "the most wanted comes first"
            assert sum(chunk["count"] for chunk in client.frames[0].chunks) == POINTS
            # A chunk that was dropped is sent again when it is wanted again.
            await client.send(type="want", frame=0, chunks=[rest[0]])
            assert (await receive_chunks(client, len(table) + 1))[-1] == rest[0]

    run(scenario)


def test_a_new_wish_replaces_the_old_one(scan: Served) -> None:
    table = table_of(scan)

    async def scenario() -> None:
        async with viewer(scan.url, scan.token, auto_credit=False) as client:
            await client.open("scan")
            await receive_chunks(client, 1)
            last = table[-1]["index"]
            await client.send(type="want", frame=0, chunks=list(range(1, last)))
            await client.send(type="want", frame=0, chunks=[last])
            await client.drain(0.3)
            for _ in range(40):
                await client.send(type="credit", frames=1)
            while table[-1]["index"] not in [c["index"] for c in client.frames[0].chunks]:
                await client.receive()

    run(scenario)


def test_a_stroke_on_a_scan_is_right_in_every_chunk(scan: Served) -> None:
    table = table_of(scan)

    async def scenario() -> None:
        async with viewer(scan.url, scan.token) as client:
            await client.open("scan")
            root = await receive_chunks(client, 1)
            first = [chunk["index"] for chunk in table[len(root) : len(table) // 2]]
            await client.send(type="want", frame=0, chunks=first)
            await receive_chunks(client, len(root) + len(first))
            stroke = str(uuid.uuid4())
            brush = {"label": 1, "radius": 0.4}
            await client.send(type="stroke_begin", id=stroke, frame=0, brush=brush)
            sample = {"origin": [0.3, 0.2, 3.0]}
            await client.send(type="stroke_samples", id=stroke, samples=[sample])
            await client.send(type="stroke_end", id=stroke)
            done = await client.until("stroke_result", id=stroke, final=True)
            assert done["changed"] > 0
            rest = [chunk["index"] for chunk in table if chunk["index"] not in root + first]
            await client.send(type="want", frame=0, chunks=rest)
            await receive_chunks(client, len(table))
            while client.frames[0].revision < done["revision"]:
                await client.receive()
            values = scan.workspace.labels.values("scan", 0).label
            assert client.frames[0].values is not None
            np.testing.assert_array_equal(client.frames[0].values, values)

    run(scenario)


def test_an_edit_of_most_of_a_scan_brings_the_values_of_the_chunks_that_are_here(
    scan: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = table_of(scan)
    monkeypatch.setattr(effect, "LISTED_POINTS", 100)

    async def scenario() -> None:
        async with viewer(scan.url, scan.token) as client:
            await client.open("scan")
            root = await receive_chunks(client, 1)
            far = table[-1]["index"]
            await client.send(type="want", frame=0, chunks=[far])
            here = [*root, far]
            assert await receive_chunks(client, len(here)) == here
            client.log.clear()
            everything = {"shape": "box", "center": [0, 0, 0], "size": [999, 999, 999]}
            brush = {"tool": "paint", "label": 1, **everything}
            commit = await asyncio.to_thread(
                scan.workspace.strokes.apply, "scan", 0, {"samples": [], **brush}, "somebody"
            )
            assert commit.changed > 1_000
            came = []
            while len(came) < 2:
                message = await client.receive()
                if message["type"] == "annotation":
                    came.append(message)
            spans = [(message["first"], message["count"]) for message in came]
            assert spans == [(table[c]["first"], table[c]["count"]) for c in here]
            assert all(message["base"] is None for message in came)
            values = scan.workspace.labels.values("scan", 0).label
            held = client.frames[0].values
            assert held is not None
            for first, count in spans:
                run_of = slice(first, first + count)
                np.testing.assert_array_equal(held[run_of], values[run_of])

    run(scenario)
