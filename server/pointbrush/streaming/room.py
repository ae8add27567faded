"""One open sequence and its viewers: tables, counts and revisions that they share."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import asdict
from typing import Any, Protocol, TypeVar

from pointbrush.labels import Cell, Commit, GapError, Label
from pointbrush.sequences import Sequence
from pointbrush.streaming import messages
from pointbrush.streaming.cache import MessageCache, Versioned
from pointbrush.streaming.encoding import (
    encode,
    encode_delta,
    encode_frame,
    encode_provisional,
    encode_whole,
)
from pointbrush.streaming.outbox import Outbox, QueuedDelta
from pointbrush.streaming.table import FrameTable
from pointbrush.workspace import Provisional, Workspace

T = TypeVar("T")
TABLES = 4096
STATES_PERIOD, STATES_PERIOD_EACH = 0.05, 0.002
Place = tuple[int, int]
"""Frame and label: a cell of the timeline."""
AT_ONCE = 50_000
"""Changed points that are encoded on the event loop itself."""
CATCH_UP_TRIES, CATCH_UP_PAUSE = 100, 0.005


class Listener(Protocol):
    """What a room needs of a viewer."""

    @property
    def id(self) -> str:
        """Tells it from the others."""

    @property
    def outbox(self) -> Outbox:
        """What waits to be sent to it."""

    def holds(self, frame: int) -> bool:
        """Whether it must hear of changes in a frame."""

    def stale(self, frames: Iterable[int]) -> None:
        """Values of these frames must be sent whole."""

    def all_stale(self) -> None:
        """Values of everything that it holds must be sent whole."""

    def cells_changed(self, cells: set[Place], *, everything: bool) -> None:
        """Palette, counts or timeline changed."""


class Room:
    """Shared by the viewers of one sequence; lives while there is one.  Event loop only."""

    def __init__(
        self,
        workspace: Workspace,
        recording: Sequence,
        cache: MessageCache,
        run: Callable[..., Awaitable[Any]],
    ) -> None:
        """``run(function, *args)`` awaits ``function`` in a worker thread."""
        self.workspace, self.recording, self.cache, self._run = workspace, recording, cache, run
        self.id = recording.manifest.id
        self._identity = recording.identity
        self.viewers: set[Listener] = set()
        self.revision = 0
        self.palette: list[Label] = []
        self.cells: dict[tuple[int, int], Cell] = {}
        self.tracks: dict[tuple[int, int], dict[str, Any]] = {}
        self._touched: dict[int, int] = {}
        self._start = 0
        self._tables: OrderedDict[int, FrameTable] = OrderedDict()
        self._palette_stale = self._tracks_stale = False
        self._refreshing = asyncio.Lock()

    async def load(self) -> None:
        """Read the state that is kept here; commits that come meanwhile only repeat it."""

        def read() -> tuple[int, list[Label], Any, list[dict[str, Any]]]:
            store = self.workspace.store
            revision = store.revision(self.id)
            return revision, store.palette(self.id), store.counts(self.id), store.tracks(self.id)

        revision, self.palette, counts, tracks = await self._run(read)
        self.revision = self._start = max(self.revision, revision)
        for (frame, label), (points, painted) in counts.items():
            self.cells.setdefault((frame, label), Cell(frame, label, points, painted))
        self.tracks = by_cell(tracks)

    # ── points ───────────────────────────────────────────────────────────────────────────

    async def table(self, frame: int) -> FrameTable:
        """The levels of a frame; raises NotFoundError."""
        table = self._tables.get(frame)
        if table is None:
            table = await self._run(lambda: FrameTable.of(self.recording[frame]))
            self._tables[frame] = table
            if len(self._tables) > TABLES:
                self._tables.popitem(last=False)
        return table

    async def frame_message(self, frame: int, first: int, stop: int, *, final: bool) -> bytes:
        """Chunks [first, stop) of a frame, encoded."""
        key = ("frame", self._identity, frame, first, stop, final)

        async def make() -> Versioned:
            return 0, await self._run(
                lambda: encode_frame(self.id, self.recording[frame], first, stop, final=final)
            )

        return (await self.cache.get(key, make))[1]

    # ── values ───────────────────────────────────────────────────────────────────────────

    async def values_message(self, frame: int, first: int, count: int) -> tuple[int, bytes]:
        """The values of a run of points as they are now, and a revision they include.

        Every commit up to that revision has been handed to the viewers' outboxes.
        """
        key = ("values", self._identity, frame, first, count)

        def read() -> Versioned:
            values = self.workspace.store.values(self.id, frame, first, count)
            return values.revision, encode_whole(self.id, frame, first, values)

        least = self._touched.get(frame, self._start)
        revision, data = await self.cache.get(key, lambda: self._run(read), least)
        for _ in range(CATCH_UP_TRIES):
            if self.revision >= revision:
                break
            # The commit has been read, but its event is still on its way here.
            await asyncio.sleep(CATCH_UP_PAUSE)
        return revision, data

    # ── events ───────────────────────────────────────────────────────────────────────────

    async def committed(self, commit: Commit) -> None:
        """Hand a commit to every viewer, in the order of revisions."""
        if commit.revision <= self.revision:
            return
        if commit.revision > self.revision + 1:
            # Something in between did not come by here: what viewers hold is sent whole.
            for viewer in self.viewers:
                viewer.all_stale()
            self._start = commit.revision - 1
            self._touched.clear()
            self._palette_stale = self._tracks_stale = True
        held = [f for f in commit.frames if any(viewer.holds(f) for viewer in self.viewers)]
        bases = {frame: self._touched.get(frame, self._start) for frame in held}
        # From here on nobody gets older values, also while the deltas are encoded.
        self._touched.update(dict.fromkeys(commit.frames, commit.revision))
        encoded = await self._encoded(commit, bases)
        self.revision = commit.revision
        for delta in encoded:
            for viewer in self.viewers:
                if viewer.holds(delta.frame):
                    viewer.outbox.delta(delta)
        changed = {(cell.frame, cell.label) for cell in commit.cells}
        self.cells.update({(cell.frame, cell.label): cell for cell in commit.cells})
        self._palette_stale |= commit.palette_changed
        self._tracks_stale |= commit.tracks_changed
        for viewer in self.viewers:
            viewer.cells_changed(changed, everything=commit.tracks_changed)

    async def _encoded(self, commit: Commit, bases: dict[int, int]) -> list[QueuedDelta]:
        """A commit's part in each frame of ``bases``, encoded once for all viewers."""

        def encode_all() -> list[QueuedDelta]:
            return [delta_message(commit, frame, base) for frame, base in bases.items()]

        # A tracking run touches many frames: too much to do while everybody waits.
        if sum(len(commit.frames[frame]) for frame in bases) > AT_ONCE:
            found: list[QueuedDelta] = await self._run(encode_all)
            return found
        return encode_all()

    def provisional(self, event: Provisional) -> None:
        """Show what a tracking run has just found."""
        data = encode_provisional(self.id, event.frame, self.revision, event.numbers, event.labels)
        for viewer in self.viewers:
            if viewer.holds(event.frame):
                viewer.outbox.delta(QueuedDelta(event.frame, self.revision, data, provisional=True))

    async def since(self, revision: int) -> list[QueuedDelta] | None:
        """Deltas of all commits after ``revision``, or None when that is too far back.

        They reach as far as what the viewers have been told when this returns: a commit that
        came while the others were read must not fall between the two.
        """
        deltas: list[QueuedDelta] = []
        touched: dict[int, int] = {}

        def read(after: int) -> int:
            commits = self.workspace.store.since(self.id, after)
            for commit in commits:
                for frame in commit.frames:
                    base = touched.get(frame, revision)
                    touched[frame] = commit.revision
                    deltas.append(delta_message(commit, frame, base))
            return commits[-1].revision

        reached = revision
        try:
            while reached < self.revision:
                reached = await self._run(read, reached)
        except GapError:
            return None
        return deltas

    # ── states ───────────────────────────────────────────────────────────────────────────

    async def refresh(self) -> None:
        """Read palette and tracks again if a commit changed them."""
        # While one viewer's task reads, the others must wait: what is here is still the old.
        async with self._refreshing:
            if self._palette_stale:
                self._palette_stale = False
                self.palette = await self._run(self.workspace.store.palette, self.id)
            if self._tracks_stale:
                self._tracks_stale = False
                self.tracks = by_cell(await self._run(self.workspace.store.tracks, self.id))

    async def labels_message(self, author: str) -> bytes:
        """The palette, its counts, and what this author can take back."""
        revision = self.revision

        async def make() -> Versioned:
            undo, redo = await self._run(self.workspace.store.stacks, self.id, author)
            message = messages.Labels(
                sequence=self.id,
                revision=revision,
                labels=[messages.Label(**asdict(label)) for label in self.palette],
                counts=self.counts(),
                undo=undo and undo.summary,
                redo=redo and redo.summary,
            )
            return revision, encode(message)

        return (await self.cache.get(("labels", self._identity, revision, author), make))[1]

    async def timeline_message(self, cells: frozenset[Place] | None) -> bytes:
        """The given cells (frame, label), or all that are not empty."""
        revision = self.revision

        async def make() -> Versioned:
            return revision, encode(self.timeline(cells))

        return (await self.cache.get(("timeline", self._identity, revision, cells), make))[1]

    @property
    def states_period(self) -> float:
        """Seconds between two messages of palette and timeline to a viewer: more in a crowd."""
        return max(STATES_PERIOD, STATES_PERIOD_EACH * len(self.viewers))

    def counts(self) -> dict[str, int]:
        """Points of each label in all frames together."""
        totals: dict[str, int] = {}
        for cell in self.cells.values():
            totals[str(cell.label)] = totals.get(str(cell.label), 0) + cell.points
        return totals

    def timeline(self, cells: Iterable[Place] | None) -> messages.Timeline:
        """The given cells, or all that are not empty."""
        chosen = self.cells.keys() | self.tracks.keys() if cells is None else cells
        rows = [self._cell(frame, label) for frame, label in sorted(chosen)]
        if cells is None:
            rows = [row for row in rows if row.points or row.state]
        return messages.Timeline(
            sequence=self.id, revision=self.revision, whole=cells is None, cells=rows
        )

    def _cell(self, frame: int, label: int) -> messages.TimelineCell:
        cell = self.cells.get((frame, label), Cell(frame, label, 0, 0))
        track = self.tracks.get((frame, label))
        return messages.TimelineCell(
            frame=frame,
            label=label,
            points=cell.points,
            painted=cell.painted,
            confidence=None if track is None else float(track["confidence"]),
            state="painted" if cell.painted else None if track is None else track["state"],
        )


def delta_message(commit: Commit, frame: int, base: int) -> QueuedDelta:
    """A commit's part in one frame, ready to be sent."""
    data = encode_delta(
        commit.sequence, frame, commit.revision, base, commit.frames[frame], commit.edit_id,
        commit.author,
    )  # fmt: skip
    return QueuedDelta(frame, commit.revision, data)


def by_cell(tracks: Iterable[dict[str, Any]]) -> dict[tuple[int, int], dict[str, Any]]:
    """Tracks by frame and label."""
    return {(int(track["frame"]), int(track["label"])): track for track in tracks}
