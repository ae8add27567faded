"""Good and poor links, slow readers: in time, newest first, bounded, and never out of step."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

from pointbrush.streaming.viewer import CREDITS
from tests.serving import Served
from tests.streaming.acting import paint, run, settled, stored_values
from tests.streaming.client import Viewer, viewer
from tests.streaming.conftest import FRAMES, POINTS
from tests.streaming.shaping import Link, shaped
from tests.waiting import PATIENCE

FPS = 30.0


async def play(client: Viewer, seconds: float, until: Callable[[], bool] = lambda: False) -> float:
    """Play for a while, or ``until`` then, keeping nothing, so that every round is sent again.

    Returns the start.
    """
    await client.open("wall", frame=0)
    await client.until("frame", frame=0)
    client.arrivals.clear()
    start = time.monotonic()
    await client.send(type="play", frame=0)
    last = -1
    while not until() and (left := start + seconds - time.monotonic()) > 0:
        try:
            message = await client.receive(left)
        except TimeoutError:
            break
        if message["type"] == "frame" and message["frame"] != last:
            gone = [frame for frame in client.frames if frame != message["frame"]]
            for frame in gone:
                del client.frames[frame]
            if gone:
                await client.send(type="forget", frames=gone)
            last = message["frame"]
    return start


@pytest.mark.parametrize("megabits", [5, 20, 100])
def test_playback_keeps_time_on_a_throttled_link(served: Served, megabits: int) -> None:
    async def scenario() -> None:
        async with (
            shaped(served.url, megabits * 1e6) as url,
            viewer(url, served.token) as client,
        ):
            start = await play(client, 4.0)
            late = []
            for moment, frame, _ in client.arrivals:
                if moment - start < 2.0:
                    continue
                due = (moment - start) * FPS
                behind = (due - frame + FRAMES / 2) % FRAMES - FRAMES / 2
                late.append(behind / FPS)
            assert len(late) > 10, "frames go on coming"
            late.sort()
            # No growing queue: what comes is what is due, give or take a round trip.
            assert late[len(late) // 2] < 0.2

    run(scenario)


def test_the_rate_control_recovers_with_the_link(served: Served) -> None:
    async def scenario() -> None:
        link = Link(2e6)
        async with shaped(served.url, link) as url, viewer(url, served.token) as client:

            def most() -> int:
                """The points of the largest of the last frames."""
                return max((points for _, _, points in client.arrivals[-20:]), default=0)

            await play(client, PATIENCE, lambda: len(client.arrivals) >= 20 and most() < POINTS / 2)
            poor = most()
            assert poor < POINTS / 2
            link.bits = 400e6
            await play(client, PATIENCE, lambda: most() > 2 * poor)
            assert most() > 2 * poor

    run(scenario)


def test_a_seek_overtakes_what_was_on_its_way(served: Served) -> None:
    async def scenario() -> None:
        async with shaped(served.url, 20e6) as url, viewer(url, served.token) as client:
            await client.open("wall", frame=0)
            await client.until("frame", frame=0, final=True)
            start = time.monotonic()
            for frame in (3, 5, 8, 11):
                await client.send(type="seek", frame=frame)
            await client.until("frame", frame=11)
            assert time.monotonic() - start < 2.0
            await client.until("frame", frame=11, final=True)
            between = [frame for _, frame, _ in client.arrivals if frame in (3, 5, 8)]
            assert len(between) <= 3, "frames scrubbed over are not sent"

    run(scenario)


def test_a_page_that_is_too_slow_gets_fewer_points(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, auto_credit=False) as client:
            await client.open("wall", frame=0)
            await client.send(type="credit", frames=1, points=POINTS // 6)
            await client.send(type="play", frame=0)
            client.frames.clear()
            end = time.monotonic() + 1.0
            shown: list[int] = []
            while time.monotonic() < end:
                message = await client.receive()
                if message["type"] == "frame":
                    held = client.frames[message["frame"]]
                    shown.append(held.points)
                    await client.send(type="credit", frames=1, points=POINTS // 6)
                    await client.send(type="forget", frames=list(client.frames))
                    client.frames.clear()
            # The first ones may have left before the wish was heard.
            assert max(shown[CREDITS:]) <= POINTS // 6

    run(scenario)


def test_without_credits_only_a_window_is_sent_but_edits_go_on(served: Served) -> None:
    async def scenario() -> None:
        async with (
            viewer(served.url, served.token, auto_credit=False) as silent,
            viewer(served.url, served.token) as anna,
        ):
            await silent.hello()
            credits = silent.log[-1]["credits"]
            await silent.open("wall", frame=0)
            await silent.send(type="play", frame=0)
            await silent.drain(1.0)
            assert 0 < len(silent.arrivals) <= credits
            frame = silent.arrivals[0][1]
            await anna.open("wall", frame=frame)
            done = await paint(anna, frame)
            await settled(silent, frame, done["revision"])

    run(scenario)


def test_a_viewer_that_does_not_read_is_right_again_when_it_does(served: Served) -> None:
    async def scenario() -> None:
        async with (
            shaped(served.url, 200e6) as url,
            viewer(url, served.token) as sleeper,
            viewer(served.url, served.token) as anna,
        ):
            await sleeper.open("wall", frame=2)
            await sleeper.until("frame", frame=2, final=True)
            await anna.open("wall", frame=2)
            await paint(anna, 2)
            for i in range(30):
                done = await paint(anna, 2, radius=1.5, tool=("erase", "paint")[i % 2])
            await settled(sleeper, 2, done["revision"])
            values = sleeper.frames[2].values
            assert values is not None
            assert (values == stored_values(served, 2)).all()

    run(scenario)
