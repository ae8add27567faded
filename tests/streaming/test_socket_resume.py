"""The socket after a lost connection: what was missed comes, what was kept does not."""

from __future__ import annotations

import time
from typing import Any

import httpx
import numpy as np

from tests.serving import Served
from tests.streaming.acting import paint, run, settled, shown, stored_values
from tests.streaming.client import viewer


def test_resuming_brings_what_was_missed(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as anna:
            await anna.open("wall", frame=6)
            revision, kept = await shown(served, 6)
            done = [await paint(anna, 6) for _ in range(3)][-1]
            async with viewer(served.url, served.token) as again:
                again.frames = kept
                await again.open("wall", frame=6, revision=revision)
                await settled(again, 6, done["revision"])
                assert again.gaps == 0
                np.testing.assert_array_equal(again.frames[6].values, stored_values(served, 6))

    run(scenario)


def test_points_that_a_viewer_kept_are_not_sent_again(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as anna:
            await anna.open("wall", frame=6)
            revision, kept = await shown(served, 6)
            done = await paint(anna, 6)
            unseen = await paint(anna, 3)
            async with viewer(served.url, served.token) as again:
                again.frames = {6: kept[6]}
                held = [[6, len(kept[6].chunks)]]
                await again.open("wall", frame=6, revision=revision, held=held)
                await settled(again, 6, done["revision"])
                await again.send(type="seek", frame=3)
                await again.until("frame", frame=3, final=True)
                assert 6 not in {frame for _, frame, _ in again.arrivals}
                assert again.frames[3].revision >= unseen["revision"]
                assert again.gaps == 0
                for frame in (3, 6):
                    wanted = stored_values(served, frame)
                    np.testing.assert_array_equal(again.frames[frame].values, wanted)

    run(scenario)


def test_what_is_held_needs_a_revision(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.send(type="open", sequence="wall", held=[[0, 1]])
            assert "revision" in (await client.until("error"))["detail"]

    run(scenario)


def test_a_revision_from_the_future_is_refused(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.send(type="open", sequence="wall", revision=10**9)
            assert (await client.until("error"))["status"] == 422
            assert not [message for message in client.log if message["type"] == "sequence"]
            await client.send(type="open", sequence="none", revision=1)
            assert (await client.until("error"))["status"] == 404

    run(scenario)


def metrics(served: Served) -> str:
    return httpx.get(f"{served.url}/metrics", headers=served.headers).raise_for_status().text


def test_what_was_changed_while_nobody_looked_is_seen(served: Served, api: httpx.Client) -> None:
    found: list[np.ndarray[Any, Any] | None] = []

    async def look() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=2)
            await client.until("frame", frame=2, final=True)
            found.append(client.frames[2].values)

    run(look)
    while "pointbrush_viewers 0.0" not in metrics(served):
        time.sleep(0.01)
    stroke = {"label": 1, "radius": 0.8, "samples": [{"origin": [0, 0, 3]}]}
    answer = api.post("/sequences/wall/frames/2/strokes", json=stroke).raise_for_status()
    assert answer.json()["changed"] > 0
    run(look)
    np.testing.assert_array_equal(found[1], stored_values(served, 2))
