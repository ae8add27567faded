"""State of a sequence beside its points: the palette, its counts and the timeline."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable
from typing import Any

import numpy as np

from pointbrush.labels import Cell, Commit, Label, LabelStore
from pointbrush.labels.boxes.maps import box_value
from pointbrush.streaming import messages
from pointbrush.streaming.encoding import encode, encode_beginning, encode_end
from pointbrush.streaming.shared.cache import MessageCache, Versioned

Place = tuple[int, int]
"""Frame and label: a cell of the timeline."""
CELL = np.dtype(
    [
        ("frames", "<u4"), ("labels", "<u2"), ("points", "<u4"), ("painted", "<u4"),
        ("confidence", "<f4"), ("states", "u1"),
    ]
)  # fmt: skip
"""A cell in the arrays of the timeline's message."""
STATES = ("none", "painted", "tracked", "occluded", "lost")
LABELS_OWN = ("undo", "redo")
"""Fields of the labels' message that depend on the author; they are its last fields."""
MESSAGES_BYTES = 2 * 2**20
"""Memory for messages that viewers share: the newest ones, which all need at the same time."""


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
        self._totals: dict[int, int] = {}
        """Number of points of each label in all frames."""
        self._edited: dict[str, int] = {}
        """Revision of each author's last edit, which an undo would take back."""
        self._all_edited = 0
        self._shared: tuple[int, bytes] = (-1, b"")
        """Revision and bytes of the part of the labels' message that is equal for all authors."""

    async def load(self) -> int:
        """Read everything and return the revision; commits during the read only repeat it."""

        def read() -> tuple[int, list[Label], Any, list[dict[str, Any]]]:
            store, sequence = self._store, self._sequence
            revision = store.revision(sequence)
            return (
                revision, store.palette(sequence), store.counts(sequence), store.tracks(sequence)
            )  # fmt: skip

        revision, self.palette, counts, tracks = await self._run(read)
        for (frame, label), (points, painted) in counts.items():
            if (frame, label) not in self.cells:
                self._put(Cell(frame, label, points, painted))
        self.tracks = by_cell(tracks)
        self.revision = max(self.revision, revision)
        return self.revision

    def on_commit(self, commit: Commit) -> set[Place]:
        """Apply a commit to the state; return the cells that it changed."""
        self.revision = commit.revision
        for cell in commit.cells:
            self._put(cell)
        self._edited[commit.author] = commit.revision
        self._palette_stale |= commit.palette_changed
        self._tracks_stale |= commit.tracks_changed
        return {(cell.frame, cell.label) for cell in commit.cells}

    def _put(self, cell: Cell) -> None:
        place = (cell.frame, cell.label)
        old = self.cells.get(place)
        change = cell.points - (old.points if old else 0)
        self.cells[place] = cell
        self._totals[cell.label] = self._totals.get(cell.label, 0) + change

    def all_changed(self) -> None:
        """Mark the state as stale after missed commits."""
        self._all_edited = self.revision + 1
        self._palette_stale = self._tracks_stale = True

    def on_classes_renamed(self) -> None:
        """Read the palette again: its categories may have other names."""
        self._palette_stale = True

    async def refresh(self) -> None:
        """Read palette and tracks again if a commit changed them."""
        # Other viewers must wait during the read: the state is old until then.
        async with self._refreshing:
            if self._palette_stale:
                self._palette_stale = False
                self.palette = await self._run(self._store.palette, self._sequence)
                self._shared = (-1, b"")
            if self._tracks_stale:
                self._tracks_stale = False
                self.tracks = by_cell(await self._run(self._store.tracks, self._sequence))

    async def labels_message(self, author: str) -> bytes:
        """Return the message of palette, counts, and the author's undo and redo.

        The part that is equal for all authors is encoded once; an author's part changes only
        with their edits.
        """
        own = await self._own_part(author)
        if self._shared[0] != self.revision:
            self._shared = (self.revision, self._shared_part())
        return self._shared[1] + own

    def _shared_part(self) -> bytes:
        message = messages.Labels(
            sequence=self._sequence,
            revision=self.revision,
            labels=[message_of(label) for label in self.palette],
            counts={str(label): points for label, points in self._totals.items()},
            undo=None,
            redo=None,
        )
        return encode_beginning(message, LABELS_OWN)

    async def _own_part(self, author: str) -> bytes:
        revision = self.revision

        async def make() -> Versioned:
            stacks = await self._run(self._store.stacks, self._sequence, author)
            texts = [edit and edit.summary for edit in stacks]
            return revision, encode_end(dict(zip(LABELS_OWN, texts, strict=True)))

        least = max(self._edited.get(author, 0), self._all_edited)
        return (await self._messages.get(("stacks", author), make, least))[1]

    async def boxes_message(self, boxes: frozenset[int] | None) -> bytes:
        """Return the message of the boxes of these ids, or of all boxes."""

        def read() -> Versioned:
            found = self._store.boxes.listing(self._sequence, ids=boxes)
            there = {box.id for box in found.boxes}
            message = messages.Boxes(
                sequence=self._sequence,
                revision=found.revision,
                whole=boxes is None,
                boxes=[box_value(box) for box in found.boxes],
                removed=sorted((boxes or frozenset()) - there),
            )
            return found.revision, encode(message)

        return (await self._messages.get(("boxes", boxes), lambda: self._run(read), self.revision))[
            1
        ]

    async def timeline_message(self, cells: frozenset[Place] | None) -> bytes:
        """Return the message of the given cells (frame, label), or of all that are not empty."""
        revision = self.revision

        async def make() -> Versioned:
            return revision, encode(self.timeline(cells))

        return (await self._messages.get(("timeline", cells), make, revision))[1]

    def timeline(self, cells: Iterable[Place] | None) -> messages.Timeline:
        """Return the given cells, or all that are not empty."""
        chosen = self.cells.keys() | self.tracks.keys() if cells is None else cells
        rows = np.array([self._cell(*place) for place in sorted(chosen)], CELL)
        if cells is None:
            rows = rows[(rows["points"] > 0) | (rows["states"] > 0)]
        return messages.Timeline(
            sequence=self._sequence,
            revision=self.revision,
            whole=cells is None,
            frames=rows["frames"].tobytes(),
            labels=rows["labels"].tobytes(),
            points=rows["points"].tobytes(),
            painted=rows["painted"].tobytes(),
            confidence=rows["confidence"].tobytes(),
            states=rows["states"].tobytes(),
        )

    def _cell(self, frame: int, label: int) -> tuple[float, ...]:
        """Return the fields of ``CELL``."""
        cell = self.cells.get((frame, label))
        points, painted = (cell.points, cell.painted) if cell else (0, 0)
        track = self.tracks.get((frame, label))
        confidence = float(track["confidence"]) if track else np.nan
        state = "painted" if painted else track["state"] if track else "none"
        return frame, label, points, painted, confidence, STATES.index(state)


def by_cell(tracks: Iterable[dict[str, Any]]) -> dict[Place, dict[str, Any]]:
    """Return the tracks by frame and label."""
    return {(int(track["frame"]), int(track["label"])): track for track in tracks}


def message_of(label: Label) -> messages.Label:
    """Return the message of a label."""
    return messages.Label(**{name: getattr(label, name) for name in messages.Label.model_fields})
