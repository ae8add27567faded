"""The socket and who is at it: presence, roles, tokens, and a sequence that goes."""

from __future__ import annotations

import asyncio
import contextlib
import uuid

import httpx
import msgpack
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from pointbrush.client import Client
from pointbrush.web.security.admissions import RECHECK_SECONDS
from pointbrush.web.socket import CLOSE_SECONDS
from pointbrush.work.projects.copies import make_copy
from tests.serving import Served
from tests.streaming.acting import run
from tests.streaming.client import viewer
from tests.waiting import PATIENCE


def test_presence_goes_to_the_others_in_the_same_sequence(served: Served) -> None:
    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as anna,
            viewer(served.url, served.token) as ben,
            viewer(served.url, served.token) as other,
        ):
            await anna.hello("Anna")
            await anna.open("wall")
            await ben.open("wall")
            await other.open("other")
            for i in range(200):
                await anna.send(type="presence", frame=3, head=[i, 0, 0, 0, 0, 0, 1])
            seen = await ben.until("presence", name="Anna")
            while seen["head"][0] != 199:
                seen = await ben.until("presence", name="Anna")
            told = [m for m in ben.log if m["type"] == "presence"]
            assert len(told) < 200, "newest wins: not every movement is relayed"
            await anna.socket.close()
            assert (await ben.until("presence", left=True))["name"] == "Anna"
            await other.drain(0.2)
            assert not [m for m in other.log if m["type"] == "presence"]
            assert not [m for m in anna.log if m["type"] == "presence"]

    run(scenario)


def test_copies_that_are_looked_at_at_once_keep_apart(served: Served) -> None:
    workspace = served.workspace
    copies = [
        make_copy(workspace.labels, workspace.library, "wall", "default", range(1), "agreement")
        for _ in range(2)
    ]
    opened = [workspace.recording(name) for name in ("wall", *copies)]
    assert len({each.identity for each in opened}) == 3
    with Client(served.url, served.token) as client:
        for number, name in enumerate(copies):
            values = np.zeros(opened[0].manifest.points[0], np.uint16)
            values[100 * number : 100 * number + 100] = 1
            client[name].frames[0].annotate(values)

    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as lead,
            viewer(served.url, served.token, keep_data=True) as anna,
            viewer(served.url, served.token, keep_data=True) as ben,
        ):
            await lead.open("wall")
            await lead.until("frame", frame=0, final=True)
            for name, one in zip(copies, (anna, ben), strict=True):
                await one.open(name)
                await one.until("frame", frame=0, final=True)
                sent = [each for each in one.log if each["type"] in ("frame", "annotation")]
                assert {each["sequence"] for each in sent} == {name}
                stored = workspace.labels.values(name, 0).label
                assert np.count_nonzero(stored) == 100
                np.testing.assert_array_equal(one.frames[0].values, stored)

    run(scenario)
    for name in copies:
        workspace.deletion.delete(name)


def test_a_viewers_token_names_its_author_and_may_not_paint(served: Served) -> None:
    secret = served.workspace.labels.tokens.add("viewer", "looks only")

    async def scenario() -> None:
        async with viewer(served.url, secret) as client:
            welcome = await client.hello("Mallory")
            # A token with a name of its own cannot borrow another author's.
            assert (welcome["author"], welcome["role"]) == ("looks only", "viewer")
            await client.open("wall")
            stroke = str(uuid.uuid4())
            await client.send(type="stroke_begin", id=stroke, frame=0, brush={"label": 1})
            error = await client.until("error")
            assert (error["status"], error["about"]) == (403, stroke)

    run(scenario)


def test_a_revoked_tokens_socket_is_closed(served: Served) -> None:
    # A fixed time, which no other test waits for: what is promised is 5 s.
    assert RECHECK_SECONDS + CLOSE_SECONDS < 5
    tokens = served.workspace.labels.tokens
    secret = tokens.add("annotator", "leaves soon")

    async def scenario() -> None:
        async with viewer(served.url, secret) as client:
            await client.open("wall")
            tokens.revoke(next(token.id for token in tokens.list() if token.name == "leaves soon"))
            with pytest.raises(ConnectionClosed) as closed:
                await client.drain(PATIENCE)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 4401

    run(scenario)


def test_a_revoked_tokens_socket_that_reads_nothing_is_cut(served: Served) -> None:
    tokens = served.workspace.labels.tokens
    secret = tokens.add("annotator", "reads nothing")
    metrics = f"{served.url}/api/v1/metrics"

    async def viewers() -> float:
        async with httpx.AsyncClient(headers=served.headers) as api:
            text = (await api.get(metrics)).text
        [line] = [line for line in text.splitlines() if line.startswith("pointbrush_viewers ")]
        return float(line.split()[1])

    async def scenario() -> None:
        async with viewer(served.url, secret) as client:
            await client.open("wall")
            client.socket.transport.pause_reading()
            ask = msgpack.packb({"type": "open", "sequence": "wall", "frame": 0})
            with contextlib.suppress(TimeoutError, ConnectionClosed):
                while True:  # until the server, whose answers nobody takes, takes no more
                    await asyncio.wait_for(client.socket.send(ask), 1)
            assert await viewers() == 1
            [mine] = [token.id for token in tokens.list() if token.name == "reads nothing"]
            tokens.revoke(mine)
            async with asyncio.timeout(20):  # the server's own pings would cut it later
                while await viewers():
                    await asyncio.sleep(0.05)
            client.socket.transport.resume_reading()
            with pytest.raises(ConnectionClosed):
                await client.drain(20)

    run(scenario)


def test_own_origin_is_welcome(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, origin=served.url) as client:
            await client.hello()

    run(scenario)


def test_deleting_a_sequence_tells_its_viewers(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("other")
            await asyncio.to_thread(served.workspace.deletion.delete, "other")
            assert (await client.until("error"))["status"] == 404
            await client.open("wall")

    run(scenario)
