"""One open sequence and its viewers: tables, messages and revisions that they share."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable
from typing import Any, Protocol

from pointbrush.errors import DamagedError, PointbrushError, UnavailableError
from pointbrush.labels import Commit, Delta, GapError
from pointbrush.sequences import Sequence, load_loops
from pointbrush.streaming.encoding import encode_delta, encode_provisional
from pointbrush.streaming.outbox import Outbox, QueuedDelta
from pointbrush.streaming.shared.board import Board, Place
from pointbrush.streaming.shared.cache import MessageCache
from pointbrush.streaming.shared.stock import Shelf, Stock
from pointbrush.streaming.shared.values import Values
from pointbrush.work.events import Provisional
from pointbrush.workspace import Workspace

STATES_PERIOD, STATES_PERIOD_EACH = 0.05, 0.002
TICK_SECONDS = 0.03
"""Shortest time for which edits of other viewers are collected for a viewer."""
TICK_SECONDS_A_VIEWER = 0.0005
"""The same time for each viewer of a room; the greater of both applies."""
AT_ONCE = 50_000
"""Most changed points that are encoded on the event loop instead of in a thread."""


class Listener(Protocol):
    """Interface of a viewer to a room."""

    @property
    def id(self) -> str:
        """Unique id of the viewer."""

    @property
    def outbox(self) -> Outbox:
        """Queue of messages to the viewer."""

    def holds(self, frame: int) -> bool:
        """Return whether the viewer needs the changes of a frame."""

    def mark_stale(self, frames: Iterable[int]) -> None:
        """Queue all values of these frames."""

    def mark_all_stale(self) -> None:
        """Queue all values of the frames that the viewer has."""

    def mark_cells_changed(self, cells: set[Place], *, everything: bool) -> None:
        """Queue changes of palette, counts or timeline."""

    def mark_boxes_changed(self, boxes: Iterable[int] | None) -> None:
        """Queue the boxes of these ids, or all boxes: None."""


class Room:
    """State shared by the viewers of one sequence while it has any.  Event loop only."""

    def __init__(
        self,
        workspace: Workspace,
        recording: Sequence,
        cache: MessageCache,
        shelf: Shelf,
        run: Callable[..., Awaitable[Any]],
    ) -> None:
        """``run(function, *args)`` awaits ``function`` in a worker thread."""
        self.workspace, self.recording, self._run = workspace, recording, run
        self.id = recording.manifest.id
        self.viewers: set[Listener] = set()
        self.cameras = False
        """Whether there are camera pictures; False while the store is unavailable."""
        self.board = Board(workspace.labels, run, self.id)
        self.values = Values(workspace.labels, (self.id, recording.identity), cache, run)
        self.stock = Stock(recording, self.values, shelf, run)
        self._ticked = 0.0
        self._tick: asyncio.TimerHandle | None = None

    async def load(self) -> None:
        """Read the room's state; commits that arrive during the read only repeat it."""
        self.cameras = await self._run(self._has_pictures)
        if self.recording.manifest.large:
            self._loading = asyncio.ensure_future(self._run(load_loops))
        self.values.begin(await self.board.load())

    @property
    def revision(self) -> int:
        """The newest commit in the outboxes of the viewers."""
        return self.values.revision

    def _has_pictures(self) -> bool:
        try:
            return self.recording.has_pictures
        except (DamagedError, UnavailableError):
            return False  # the cloud is shown without pictures

    # ── events ───────────────────────────────────────────────────────────────────────────

    async def on_commit(self, commit: Commit) -> None:
        """Hand a commit to every viewer, in the order of revisions."""
        if commit.revision <= self.revision:
            return
        if commit.revision > self.revision + 1:
            # Commits were missed: send all values of the frames that viewers have.
            for viewer in self.viewers:
                viewer.mark_all_stale()
                viewer.mark_boxes_changed(None)
            self.values.missed(commit.revision - 1)
            self.board.all_changed()
        held = [f for f in commit.frames if any(viewer.holds(f) for viewer in self.viewers)]
        bases = {frame: self.values.last_change(frame) for frame in held}
        # From here on no viewer gets older values, even while the deltas are encoded.
        self.values.change(commit.frames, commit.revision)
        try:
            encoded = await self._encoded(commit, bases)
        except PointbrushError:
            # The database is unavailable: queue all values of each frame until it is back.
            encoded, whole = [], held
        else:
            whole = [frame for frame in held if commit.frames[frame] is None]
        self.values.revision = commit.revision
        for delta in encoded:
            for viewer in self.viewers:
                if viewer.holds(delta.frame):
                    viewer.outbox.delta(delta)
        changed = self.board.on_commit(commit)
        for viewer in self.viewers:
            viewer.mark_stale(whole)
            viewer.mark_cells_changed(changed, everything=commit.tracks_changed)
            viewer.mark_boxes_changed(commit.boxes)
        self._schedule_wake()

    def on_retracted(self, frames: Iterable[int]) -> None:
        """Send values of frames whole: a run's provisional findings are void."""
        for viewer in self.viewers:
            viewer.mark_stale(frames)

    def on_classes_renamed(self) -> None:
        """Send every viewer the palette again."""
        self.board.on_classes_renamed()
        for viewer in self.viewers:
            viewer.mark_cells_changed(set(), everything=False)
        self._schedule_wake()

    def _schedule_wake(self) -> None:
        """Wake the viewers for waiting messages: at once after a pause, else with the tick.

        Waking each viewer for each edit of many viewers would take most of the loop's time.
        """
        loop = asyncio.get_running_loop()
        if self._tick is None:
            self._tick = loop.call_at(self._ticked + self.tick_period, self._wake_all)

    def _wake_all(self) -> None:
        self._tick, self._ticked = None, asyncio.get_running_loop().time()
        for viewer in self.viewers:
            viewer.outbox.wake.set(points=False)

    @property
    def tick_period(self) -> float:
        """Return the seconds for which edits are collected; more with many viewers."""
        return max(TICK_SECONDS, TICK_SECONDS_A_VIEWER * len(self.viewers))

    async def _encoded(self, commit: Commit, bases: dict[int, int]) -> list[QueuedDelta]:
        """Encode a commit's delta in each frame of ``bases`` once for all viewers."""
        listed = {frame: delta for frame in bases if (delta := commit.frames[frame]) is not None}

        accounts = self.workspace.labels.accounts
        author = accounts.known(commit.author)
        if author is None:
            author = str(await self._run(accounts.name, commit.author))

        def encode_all() -> list[QueuedDelta]:
            return [
                delta_message(commit, frame, delta, bases[frame], author)
                for frame, delta in listed.items()
            ]

        # Encoding the frames of a tracking run here would block the event loop.
        if sum(map(len, listed.values())) > AT_ONCE:
            found: list[QueuedDelta] = await self._run(encode_all)
            return found
        return encode_all()

    def provisional(self, event: Provisional) -> None:
        """Send provisional points of a tracking run to the viewers."""
        data = encode_provisional(self.id, event.frame, self.revision, event.numbers, event.labels)
        for viewer in self.viewers:
            if viewer.holds(event.frame):
                viewer.outbox.delta(QueuedDelta(event.frame, self.revision, data, provisional=True))
        self._schedule_wake()

    async def since(self, revision: int) -> list[QueuedDelta] | None:
        """Return the deltas of all commits after ``revision``, or None if that is too far back.

        They include every commit that the other viewers have when this returns, also the ones
        that arrive during the read.
        """
        deltas: list[QueuedDelta] = []
        touched: dict[int, int] = {}

        def read(after: int) -> int:
            commits = self.workspace.labels.since(self.id, after)
            for commit in commits:
                for frame, delta in commit.frames.items():
                    if delta is None:
                        raise GapError(f"frame {frame}: too many points changed to list them")
                    base = touched.get(frame, revision)
                    touched[frame] = commit.revision
                    author = self.workspace.labels.accounts.name(commit.author)
                    deltas.append(delta_message(commit, frame, delta, base, author))
            return commits[-1].revision

        reached = revision
        try:
            while reached < self.revision:
                reached = await self._run(read, reached)
        except GapError:
            return None
        return deltas

    @property
    def states_period(self) -> float:
        """Return the seconds between two messages of palette and timeline to a viewer."""
        return max(STATES_PERIOD, STATES_PERIOD_EACH * len(self.viewers))


def delta_message(commit: Commit, frame: int, delta: Delta, base: int, author: str) -> QueuedDelta:
    """Encode a commit's part in one frame; ``author`` is the displayed name."""
    data = encode_delta(commit.sequence, frame, commit.revision, base, delta, commit.edit, author)
    return QueuedDelta(frame, commit.revision, data)
