"""State of a sequence beside its points: the palette, its counts and the timeline."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable
from typing import Any

from pointbrush.labels import Cell, Commit, Label, LabelStore
from pointbrush.streaming import messages
from pointbrush.streaming.encoding import encode
from pointbrush.streaming.shared.cache import MessageCache, Versioned

Place = tuple[int, int]
"""Frame and label: a cell of the timeline."""
MESSAGES_BYTES = 2 * 2**20
"""Memory for messages that viewers share: the newest, which all want in the same moment."""


class Board:
    """Palette, counts and tracks as of ``revision``, and their messages.  Event loop only."""

    def __init__(
        self,
        store: LabelStore,
        run: Callable[..., Awaitable[Any]],
        sequence: str,
    ) -> None:
        """``run(function, *args)`` awaits ``function`` in a worker thread."""
        self._store, self._run, self._sequence = store, run, sequence
        self._messages = MessageCache(MESSAGES_BYTES)
        self.revision = 0
        self.palette: list[Label] = []
        self.cells: dict[Place, Cell] = {}
        self.tracks: dict[Place, dict[str, Any]] = {}
        self._palette_stale = self._tracks_stale = False
        self._refreshing = asyncio.Lock()

    async def load(self) -> int:
        """Read everything; returns the revision.  Commits that come meanwhile only repeat it."""

        def read() -> tuple[int, list[Label], Any, list[dict[str, Any]]]:
            store, sequence = self._store, self._sequence
            revision = store.revision(sequence)
            return (
                revision, store.palette(sequence), store.counts(sequence), store.tracks(sequence)
            )  # fmt: skip

        revision, self.palette, counts, tracks = await self._run(read)
        for (frame, label), (points, painted) in counts.items():
            self.cells.setdefault((frame, label), Cell(frame, label, points, painted))
        self.tracks = by_cell(tracks)
        self.revision = max(self.revision, revision)
        return self.revision

    def committed(self, commit: Commit) -> set[Place]:
        """Take in a commit; returns the cells that it changed."""
        self.revision = commit.revision
        self.cells.update({(cell.frame, cell.label): cell for cell in commit.cells})
        self._palette_stale |= commit.palette_changed
        self._tracks_stale |= commit.tracks_changed
        return {(cell.frame, cell.label) for cell in commit.cells}

    def all_changed(self) -> None:
        """Commits were missed: nothing here may be right."""
        self._palette_stale = self._tracks_stale = True

    async def refresh(self) -> None:
        """Read palette and tracks again if a commit changed them."""
        # While one viewer's task reads, the others must wait: what is here is still the old.
        async with self._refreshing:
            if self._palette_stale:
                self._palette_stale = False
                self.palette = await self._run(self._store.palette, self._sequence)
            if self._tracks_stale:
                self._tracks_stale = False
                self.tracks = by_cell(await self._run(self._store.tracks, self._sequence))

    async def labels_message(self, author: str) -> bytes:
        """The palette, its counts, and what this author can take back."""
        revision = self.revision

        async def make() -> Versioned:
            undo, redo = await self._run(self._store.stacks, self._sequence, author)
            message = messages.Labels(
                sequence=self._sequence,
                revision=revision,
                labels=[message_of(label) for label in self.palette],
                counts=self.counts(),
                undo=undo and undo.summary,
                redo=redo and redo.summary,
            )
            return revision, encode(message)

        return (await self._messages.get(("labels", author), make, revision))[1]

    async def timeline_message(self, cells: frozenset[Place] | None) -> bytes:
        """The given cells (frame, label), or all that are not empty."""
        revision = self.revision

        async def make() -> Versioned:
            return revision, encode(self.timeline(cells))

        return (await self._messages.get(("timeline", cells), make, revision))[1]

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
            sequence=self._sequence, revision=self.revision, whole=cells is None, cells=rows
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


def by_cell(tracks: Iterable[dict[str, Any]]) -> dict[Place, dict[str, Any]]:
    """Tracks by frame and label."""
    return {(int(track["frame"]), int(track["label"])): track for track in tracks}


def message_of(label: Label) -> messages.Label:
    """A label as viewers need it."""
    return messages.Label(**{name: getattr(label, name) for name in messages.Label.model_fields})
