"""The socket, as a page sees it: points come coarse to complete, and within their error."""

from __future__ import annotations

import asyncio

import numpy as np

from pointbrush.sequences import open_sequence
from tests.sequences.vertex_decoder import decode_points
from tests.serving import Served
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer
from tests.streaming.conftest import FRAMES, POINTS


def test_opening_shows_the_frame_coarse_to_complete(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, keep_data=True) as client:
            welcome = await client.hello("Anna")
            assert (welcome["role"], welcome["author"]) == ("admin", "Anna")
            info = await client.open("wall", frame=3)
            assert (info["frames"], info["frame"]) == (FRAMES, 3)
            while not (3 in client.frames and client.frames[3].final):
                await client.receive()
        held = client.frames[3]
        numbers = [chunk["first"] for chunk in held.chunks]
        assert numbers == sorted(numbers)
        # All points, each once: runs join without gap or overlap.
        ends = np.cumsum([chunk["count"] for chunk in held.chunks])
        assert numbers == [0, *ends[:-1].tolist()]
        assert ends[-1] == held.total == POINTS + 30
        kinds = [message["type"] for message in client.log]
        assert kinds[:2] == ["welcome", "sequence"]
        first = kinds.index("frame")
        assert "annotation" in kinds[:first], "points must not show without their labels"

    run(scenario)


def test_a_cap_on_points_holds_until_the_page_lifts_it(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, auto_credit=False) as client:
            await client.send(type="credit", frames=0, points=1)
            await client.open("wall", frame=2)
            await client.until("frame", frame=2)
            await client.drain(0.3)
            taken = len(client.arrivals)
            await client.send(type="credit", frames=taken, nbytes=client.nbytes, points=1)
            await client.drain(0.3)
            capped = client.frames[2]
            assert not capped.final
            first = sum(chunk["count"] for chunk in capped.chunks)
            assert first < capped.total
            late = len(client.arrivals) - taken
            await client.send(type="credit", frames=late, nbytes=client.nbytes, points=1)
            # A credit for no frame says only how the page keeps up.
            await client.send(type="credit", frames=0)
            client.auto_credit = True
            while not client.frames[2].final:
                await client.receive()
            assert sum(chunk["count"] for chunk in client.frames[2].chunks) == capped.total

    run(scenario)


def test_positions_are_within_the_manifests_error(served: Served) -> None:
    async def scenario() -> Viewer:
        async with viewer(served.url, served.token, keep_data=True) as client:
            info = await client.open("wall", frame=0)
            while not (0 in client.frames and client.frames[0].final):
                await client.receive()
            client.log.append(info)
            return client

    client = asyncio.run(scenario())
    path = served.workspace.settings.workspace / "sequences" / "wall"
    stored = open_sequence(path)[0]
    frames = [m for m in client.log if m["type"] == "frame" and m["frame"] == 0]
    for message in frames:
        for chunk in message["chunks"]:
            start, count = chunk["offset"], chunk["count"]
            data = message["data"][start : start + chunk["nbytes"]]
            raw = np.ascontiguousarray(decode_points(data, count))
            q = raw[:, :6].copy().view("<u2")
            xyz = np.array(chunk["origin"]) + q * np.array(chunk["scale"])
            exact = stored.xyz[chunk["first"] : chunk["first"] + count]
            assert np.abs(xyz - exact).max() <= client.log[-1]["position_error"] + 1e-6
            assert stored.rgb is not None
            np.testing.assert_array_equal(
                raw[:, 6:9], stored.rgb[chunk["first"] : chunk["first"] + count]
            )
