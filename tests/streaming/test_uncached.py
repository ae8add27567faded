"""Points on their way out: views of mapped files, which the page cache holds and nothing else."""

from __future__ import annotations

import asyncio
import mmap
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgpack
import pytest

from pointbrush.sequences.octree.arrays import map_file
from pointbrush.sequences.storage.residence import can_tell, in_memory, read_in
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.metrics import Metrics
from pointbrush.streaming.session import Admitted, ViewerSession
from pointbrush.streaming.shared.cache import MessageCache
from pointbrush.streaming.shared.stock import OpenFrame, Shelf
from pointbrush.workspace import Workspace
from tests.serving import Served, add_sequence, serving, settings_in
from tests.streaming.client import viewer
from tests.waiting import PATIENCE

LOOP = 260
"""Frames: more than a recording keeps open by itself."""
POINTS = 400


class Reader:
    """A viewer who asks for one frame after the other, and notes how each message was sent."""

    def __init__(self, hub: Hub) -> None:
        self.sent: list[tuple[bytes | memoryview, ...]] = []
        self._up: asyncio.Queue[bytes | None] = asyncio.Queue()
        self._came = asyncio.Event()
        self._hub = hub

    async def send(self, *parts: bytes | memoryview, before: bytes | None = None) -> None:
        self.sent += [parts] if before is None else [(before,), parts]
        self._came.set()

    def say(self, **message: Any) -> None:
        self._up.put_nowait(msgpack.packb(message))

    async def run(self) -> None:
        session = ViewerSession(
            self._hub,
            self.send,
            Admitted("Ada", "Ada", "admin", shared=False, require_admitted=lambda: None),
        )
        await session.run(self._up.get)

    async def frame(self, number: int) -> tuple[bytes | memoryview, ...]:
        """The parts of the message that completes a frame; asks for it again afterwards."""
        self.say(type="seek", frame=number)
        while True:
            while self.sent:
                parts = self.sent.pop(0)
                message = msgpack.unpackb(b"".join(parts))
                if message["type"] == "frame":
                    self.say(type="credit", frames=1)
                    self.say(type="forget", frames=[message["frame"]])
                    if message["frame"] == number and message["final"]:
                        return parts
            self._came.clear()
            await self._came.wait()


@pytest.mark.parametrize("values", ["kept", "none"])
def test_a_long_loop_costs_no_thread_once_it_was_seen(tmp_path: Path, values: str) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "long", frames=LOOP, points=POINTS)
    calls: list[Callable[..., Any]] = []

    class Counting(Hub):
        async def read(self, function: Callable[..., Any], *args: Any) -> Any:
            calls.append(function)
            return await super().read(function, *args)

    async def scenario(workspace: Workspace) -> None:
        hub = Counting(workspace, Metrics())
        if values == "none":
            # Values are kept as long as there is room; points do not depend on it.
            hub.values = MessageCache(budget=0)
        async with hub.running():
            reader = Reader(hub)
            running = asyncio.create_task(reader.run())
            reader.say(type="open", sequence="long")
            for number in range(LOOP):
                await reader.frame(number)
            await asyncio.sleep(0.05)
            before = len(calls)
            for number in range(LOOP):
                head, data = await reader.frame(number)
                assert isinstance(data, memoryview)
                assert isinstance(data.obj, mmap.mmap), "no copy"
                assert len(head) < 2_000
            of_values = [call for call in calls[before:] if "Values.message" in str(call)]
            assert len(calls) - before == len(of_values)
            assert bool(of_values) == (values == "none")
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            assert len(hub.shelf) == 0, "nobody looks at it any more"

    workspace = Workspace(settings)
    try:
        asyncio.run(asyncio.wait_for(scenario(workspace), PATIENCE))
    finally:
        workspace.close()


def test_bytes_that_are_not_in_memory_are_told_and_read_in(tmp_path: Path) -> None:
    path = tmp_path / "cold"
    with path.open("wb") as file:
        file.truncate(64 << 20)
    view = map_file(path)
    if not can_tell(path):
        pytest.skip("this system does not tell")
    assert not in_memory(view[: 2 * mmap.PAGESIZE])
    read_in(view[5 : 2 * mmap.PAGESIZE])
    assert in_memory(view[: 2 * mmap.PAGESIZE])
    assert not in_memory(view)
    assert in_memory(view[:0])
    read_in(view)
    assert in_memory(view)


def test_frames_on_the_shelf_are_bounded_by_the_files_one_may_open() -> None:
    shelf = Shelf(limit=3)
    for number in range(5):
        shelf.put(("a", number), OpenFrame(stored=None, table=None, depth=None))  # type: ignore[arg-type]
        shelf.known(("a", 0))
    assert [number for number in range(5) if shelf.known(("a", number))] == [0, 3, 4]
    shelf.forget("a")
    assert len(shelf) == 0


@pytest.fixture
def damaged(tmp_path: Path) -> Any:
    """A server whose recording ``wall`` lacks the points of frame 2 and the bytes of frame 4."""
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=6, points=3_000)
    frames = settings.workspace / "sequences" / "wall" / "frames"
    os.truncate(frames / "000002.points", 100)
    (frames / "000004.wire").unlink()
    with serving(settings) as running:
        yield running


def test_a_damaged_frame_is_told_and_the_others_come(damaged: Served) -> None:
    async def scenario() -> None:
        async with viewer(damaged.url, damaged.token) as client:
            await client.open("wall", frame=2)
            told: set[str] = set()
            while len(told) < 2 or len(client.frames) < 4:
                message = await client.receive()
                if message["type"] == "error":
                    assert message["detail"] not in told, "told once"
                    told.add(message["detail"])
            for frame in (0, 1, 3, 5):
                await client.send(type="forget", frames=[frame])
                await client.send(type="seek", frame=frame)
                await client.until("frame", frame=frame, final=True)

    asyncio.run(asyncio.wait_for(scenario(), PATIENCE))
