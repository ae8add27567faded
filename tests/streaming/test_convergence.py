"""Random interleavings of several people's edits, looks and lost links: all end with the same."""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pointbrush.database.job import Job
from pointbrush.errors import UnavailableError
from pointbrush.labels import effect
from pointbrush.streaming import hub as hub_module
from pointbrush.streaming import outbox, sender
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.metrics import Metrics
from pointbrush.streaming.room import Room
from pointbrush.streaming.session import Admitted, ViewerSession
from pointbrush.workspace import Workspace
from tests.serving import add_sequence, settings_in
from tests.streaming.client import HeldFrame, Message, Viewer
from tests.waiting import PATIENCE, comes_true

PEOPLE, FRAMES, LABELS = 3, 3, 2


class Pipe:
    """The client's end of a socket that is two queues."""

    def __init__(self) -> None:
        self.up: asyncio.Queue[bytes | None] = asyncio.Queue()
        self.down: asyncio.Queue[bytes] = asyncio.Queue()

    async def send(self, data: bytes) -> None:
        self.up.put_nowait(data)


class PageLike(Viewer):
    """Takes frames in as the page does: only what joins on; asks again for what does not."""

    async def _apply(self, message: Message, nbytes: int) -> None:
        if message["type"] == "frame":
            held = self.frames.setdefault(message["frame"], HeldFrame(message["total"]))
            first = message["chunks"][0]["index"]
            if first != len(held.chunks):
                await self.send(type="credit", frames=1, nbytes=nbytes)
                if first > len(held.chunks):
                    del self.frames[message["frame"]]
                    await self.send(type="forget", frames=[message["frame"]])
                return
        if message["type"] == "sequence":
            for held in self.frames.values():
                held.revision = max(held.revision, message["revision"])
        await super()._apply(message, nbytes)

    def _annotation(self, message: Message) -> None:
        # It was on its way when the frame was given up.
        if message["base"] is None or message["frame"] in self.frames:
            super()._annotation(message)


class Person:
    """Somebody at a page whose link breaks now and then."""

    def __init__(self, hub: Hub, name: str, sees: Callable[[Job], bool] | None = None) -> None:
        self.hub, self.name, self.sees = hub, name, sees
        self.jobs: set[str] = set()
        self.frames: dict[int, HeldFrame] = {}
        self.revision: int | None = None
        self.gaps = 0
        self.flowing = asyncio.Event()
        self.flowing.set()
        self.lets_through: int | None = None
        """Messages that come through before the link stalls, or None: all of them."""

    async def connect(self) -> None:
        self._pipe = pipe = Pipe()
        session = ViewerSession(
            self.hub,
            self._sender(pipe),
            Admitted("owner", "owner", "admin", True, lambda: None, sees=self.sees),
        )
        self.view = PageLike(pipe, on_message=self._heard, frames=self.frames)  # type: ignore[arg-type]
        self._tasks = [
            asyncio.create_task(session.run(pipe.up.get)),
            asyncio.create_task(self._read()),
        ]
        await self.view.send(type="hello", name=self.name)
        known: dict[str, Any] = {}
        if self.revision is not None:
            held = [[index, len(frame.chunks)] for index, frame in self.frames.items()]
            # One back: of the newest edit perhaps not every frame's part has come.
            known = {"revision": max(0, self.revision - 1), "held": [h for h in held if h[1]]}
        await self.view.send(type="open", sequence="wall", **known)

    def _sender(self, pipe: Pipe) -> Any:
        async def send(*parts: bytes | memoryview, before: bytes | None = None) -> None:
            if before is not None:
                await send(before)
            data = b"".join(parts)
            await self.flowing.wait()
            if self.lets_through is not None:
                self.lets_through -= 1
                if self.lets_through == 0:
                    self.flowing.clear()
            pipe.down.put_nowait(data)

        return send

    async def _read(self) -> None:
        while True:
            data = await self._pipe.down.get()
            await self.view._apply(msgpack.unpackb(data), len(data))

    def _heard(self, message: Message) -> None:
        if message["type"] == "job":
            self.jobs.add(message["id"])
        if message["type"] == "sequence" and self.revision is None:
            self.revision = message["revision"]
        if message["type"] == "annotation" and message["base"] is not None:
            self.revision = max(self.revision or 0, message["revision"])

    async def leave(self) -> None:
        """The link breaks: what is on its way is lost."""
        for task in self._tasks:
            task.cancel()
        self.flowing.set()
        self.lets_through = None
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self.gaps += self.view.gaps

    async def do(self, action: str, number: int) -> None:
        send, frame = self.view.send, number % FRAMES
        if action in ("paint", "erase", "delete", "restore"):
            edit, x = str(uuid.uuid4()), (number % 7) / 2 - 1.5
            brush = {"tool": action, "label": 1 + number % LABELS, "radius": 0.5}
            await send(type="stroke_begin", id=edit, frame=frame, brush=brush)
            await send(type="stroke_samples", id=edit, samples=[{"origin": [x, 0.0, 3.0]}])
            await send(type="stroke_end", id=edit)
        elif action in ("undo", "redo"):
            await send(type=action, id=str(uuid.uuid4()))
        elif action == "seek":
            await send(type="seek", frame=frame)
        elif action == "play":
            await send(type="play", frame=frame)
        elif action == "forget" and frame in self.frames and self.frames[frame].chunks:
            del self.frames[frame]
            await send(type="forget", frames=[frame])
        elif action == "stall":
            self.flowing.clear()
            asyncio.get_running_loop().call_later(0.002 * (number % 10), self.flowing.set)
        elif action == "relink":
            await self.leave()
            await asyncio.sleep(0.002 * (number % 10))  # while others go on
            await self.connect()
        else:
            await asyncio.sleep(0.001 * (number % 10))

    async def ask(self) -> None:
        """An edit that is refused: its answer comes after all that was sent before."""
        self._end = str(uuid.uuid4())
        await self.view.send(type="stroke_end", id=self._end)

    @property
    def unheard(self) -> bool:
        """Whether the server has not yet answered what was sent last."""
        return not any(m["type"] == "error" and m["about"] == self._end for m in self.view.log)

    def has_all(self, frame: int) -> bool:
        """Whether all points of a frame have come."""
        held = self.frames.get(frame)
        return held is not None and held.points == held.total

    def stale(self, wanted: list[np.ndarray[Any, Any]]) -> list[int]:
        """Frames that are shown otherwise than they are."""
        shown = {i: held for i, held in self.frames.items() if held.points}
        return [
            index
            for index, held in shown.items()
            if held.values is None
            or not np.array_equal(held.values[: held.points], wanted[index][: held.points])
        ]


ACTIONS = st.sampled_from(
    ["paint", "paint", "erase", "delete", "restore", "undo", "redo", "seek", "play", "forget",
     "relink", "stall", "wait"]
)  # fmt: skip
STEPS = st.lists(st.tuples(st.integers(0, PEOPLE - 1), ACTIONS, st.integers(0, 41)), max_size=40)


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workspace]:
    chosen = settings_in(tmp_path_factory.mktemp("converging"))
    add_sequence(chosen, "wall", frames=FRAMES, points=9_000)
    with closing(Workspace(chosen)) as opened:
        for number in range(LABELS):
            opened.labels.create_label("wall", "setup", name=f"label {number}")
        yield opened


def stored(workspace: Workspace) -> list[np.ndarray[Any, Any]]:
    found = [workspace.labels.values("wall", frame) for frame in range(FRAMES)]
    return [np.where(v.deleted, np.uint16(65535), v.label) for v in found]


async def play_out(workspace: Workspace, steps: list[tuple[int, str, int]]) -> None:
    async with Hub(workspace, Metrics()).running() as hub:
        people = [Person(hub, f"person {number}") for number in range(PEOPLE)]
        for person in people:
            await person.connect()
        for who, action, number in steps:
            await people[who].do(action, number)
        for person in people:
            await person.ask()
        await comes_true(lambda: not any(person.unheard for person in people))
        wanted = stored(workspace)
        await comes_true(lambda: not any(p.stale(wanted) or not p.frames for p in people))
        for person in people:
            await person.leave()
        assert [person.gaps for person in people] == [0] * PEOPLE


@given(steps=STEPS)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_everybody_ends_with_what_is_stored(
    workspace: Workspace, steps: list[tuple[int, str, int]]
) -> None:
    asyncio.run(asyncio.wait_for(play_out(workspace, steps), 2 * PATIENCE))


@given(steps=STEPS)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_everybody_does_so_too_where_deltas_give_way_to_values_in_several_runs(
    workspace: Workspace, steps: list[tuple[int, str, int]]
) -> None:
    """What a slow viewer of large frames meets, with little bounds in place of much data."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(outbox, "MOST_DELTA_BYTES", 1_500)
        patch.setattr(sender, "VALUES_RUN", 2_500)
        patch.setattr(effect, "LISTED_POINTS", 400)
        asyncio.run(asyncio.wait_for(play_out(workspace, steps), 2 * PATIENCE))


def test_no_delta_overtakes_what_is_owed_to_a_slow_viewer(workspace: Workspace) -> None:
    """It counts what it has by the newest delta: what was owed before would never come again."""

    async def scenario() -> None:
        async with Hub(workspace, Metrics()).running() as hub:
            slow, painter = Person(hub, "slow"), Person(hub, "painter")
            for person in (slow, painter):
                await person.connect()
                for frame in (1, 0):
                    await person.do("seek", frame)
                    await comes_true(partial(person.has_all, frame))
            # 1. A delta fills the link; those behind it give way to the frame's whole values.
            slow.flowing.clear()
            for number in range(8):
                await painter.do("erase" if number % 2 else "paint", FRAMES * number)
                await settled(painter)
            # 2. Another frame changes, and its delta waits as well.
            await painter.do("paint", FRAMES * 7 + 1)
            await settled(painter)
            # 3. Two messages come through, and the link breaks.
            slow.lets_through = 2
            slow.flowing.set()
            await asyncio.sleep(0.1)
            await slow.leave()
            await slow.connect()
            await comes_true(lambda: not slow.stale(stored(workspace)))
            for person in (slow, painter):
                await person.leave()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(outbox, "MOST_DELTA_BYTES", 1_500)
        asyncio.run(asyncio.wait_for(scenario(), 2 * PATIENCE))


def test_a_job_is_told_once_the_database_says_whom_it_is_for(workspace: Workspace) -> None:
    asked: list[Job] = []

    def sees(job: Job) -> bool:
        asked.append(job)
        if len(asked) == 1:
            raise UnavailableError("its server cannot be reached")
        return True

    async def scenario() -> None:
        async with Hub(workspace, Metrics()).running() as hub:
            person = Person(hub, "ada", sees)
            await person.connect()
            await comes_true(lambda: person.revision is not None)
            job = Job(kind="tracking", sequence="wall", state="done")
            workspace._listeners.notify(job)
            await comes_true(lambda: job.id in person.jobs)
            await person.leave()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hub_module, "RESEND_SECONDS", 0.01)
        asyncio.run(asyncio.wait_for(scenario(), 2 * PATIENCE))
    assert len(asked) == 2


async def settled(person: Person) -> None:
    """All that somebody sent has been answered."""
    await person.ask()
    await comes_true(lambda: not person.unheard)


def test_a_followers_messages_are_made_before_they_are_wanted(workspace: Workspace) -> None:
    async def scenario() -> None:
        hub = Hub(workspace, Metrics())
        async with hub.running():
            room = Room(workspace, workspace.recording("wall"), hub.values, hub.shelf, hub.read)
            await room.load()
            room.stock.expect(2, 1)
            while (table := room.stock.known_table(2)) is None:
                await asyncio.sleep(0.001)
            piece = table.first_piece(2, 1)
            assert piece.stop == table.stops[1]
            while (ready := room.stock.ready(piece)) is None:
                await asyncio.sleep(0.001)
            assert ready == await room.stock.messages(piece)
            assert msgpack.unpackb(b"".join(ready[2]))["total"] == table.firsts[-1]

    asyncio.run(asyncio.wait_for(scenario(), PATIENCE))
