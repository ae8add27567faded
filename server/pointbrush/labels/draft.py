"""An edit before its commit: the changes that it would make to points.

A draft does not change the state; a discarded draft has no effect.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection

from pointbrush.cache import Cache
from pointbrush.labels.blocks import Place
from pointbrush.labels.packing import (
    BLOCK,
    CONFIDENCE_BITS,
    DELETED_BIT,
    DELETED_SHIFT,
    DELETION,
    LABEL_BITS,
    LABELS,
    PROVENANCE_BITS,
    VALUE_BITS,
    WRITER_SHIFT,
    Change,
    States,
    decode_change,
    encode_change,
    provenance_of,
    written_by,
)
from pointbrush.labels.state import SequenceState, exists_table, visible
from pointbrush.labels.types import PAINTED, PREDICTED, Label, Write
from pointbrush.labels.writes import BlockWrite, cut, locked_error

OPEN_POINTS = 4_000_000
"""Number of points with unpacked changes in memory, 24 bytes each."""


class Changes(Mapping[Place, Change]):
    """Changes by place, ordered by place; ``put`` adds or replaces one."""

    def __init__(self, packed: Mapping[Place, bytes] | None = None) -> None:
        """``packed``: an edit's changes as stored in the journal."""
        self._packed: dict[Place, bytes] = dict(packed or {})
        self._open: Cache[Place, Change] = Cache(OPEN_POINTS)

    def __getitem__(self, place: Place) -> Change:
        change = self._open.known(place)
        return decode_change(self._packed[place]) if change is None else change

    def __contains__(self, place: object) -> bool:
        return place in self._packed or place in self._open

    def __iter__(self) -> Iterator[Place]:
        return iter(sorted([*self._open.held(), *self._packed]))

    def __len__(self) -> int:
        return len(self._open) + len(self._packed)

    def put(self, place: Place, change: Change) -> None:
        """Set the change of a place."""
        self._packed.pop(place, None)
        for oldest, old in self._open.put(place, change, len(change.indices)):
            self._packed[oldest] = encode_change(old)

    def packed(self, place: Place) -> bytes:
        """Return the change of a place as stored in the journal."""
        change = self._open.known(place)
        return self._packed[place] if change is None else encode_change(change)

    def clear(self) -> None:
        """Remove all changes."""
        self._packed.clear()
        self._open.drop(*self._open.held())


@dataclass(slots=True, eq=False)
class Draft:
    """Changes of one edit (revision ``state.revision + 1``), gathered place by place."""

    connection: Connection
    state: SequenceState
    changes: Changes = field(default_factory=Changes)
    labels: dict[int, Label | None] = field(default_factory=dict)
    """Palette entries that it sets; None: removes."""
    label_fields: dict[int, dict[str, Any]] = field(default_factory=dict)
    """The fields of labels that the edit sets, for the journal."""
    doubtful: set[int] = field(default_factory=set)
    """Labels that an undo or redo removes from the palette unless points hold them."""
    tracks: dict[tuple[int, int], str | None] = field(default_factory=dict)
    """Tracks by frame and label that it sets, as JSON; None: removes."""
    boxes: dict[int, dict[str, Any] | None] = field(default_factory=dict)
    """Fields of boxes that it sets; None: removes."""
    box_changes: dict[int, dict[str, Any]] = field(default_factory=dict)
    """The fields of boxes that the edit changes, for the journal."""
    own_tracks: bool = False
    """The edit sets the tracks itself, as opposed to an undo that restores earlier tracks."""

    @property
    def revision(self) -> int:
        """Return the revision of its commit."""
        return self.state.revision + 1

    @property
    def palette(self) -> dict[int, Label]:
        """Return the palette after this edit."""
        merged = {**self.state.palette, **self.labels}
        return {number: label for number, label in merged.items() if label is not None}

    @property
    def exists(self) -> NDArray[np.bool_]:
        """Return the mask of the labels that exist after this edit."""
        return exists_table(self.palette) if self.labels else self.state.exists

    def words(self, place: Place, indices: NDArray[np.int64]) -> States:
        """Return the words at ``indices`` of a place, including this draft's changes so far."""
        words = self.state.block(self.connection, place).words(indices)
        change = self.changes.get(place)
        if change is not None:
            at, mine = match_sorted(change.indices, indices)
            words[mine] = change.after[at]
        return words

    def write(self, frame: int, write: Write) -> None:
        """Add the changes of a Write, except points of locked labels and points it excludes.

        Raises BadInputError, NotFoundError, LockedLabelError, HiddenLabelError.
        """
        points = self.state.frame_points(frame)
        spared = self._spared(write.hidden)
        for piece in cut(write, points, self.palette):
            self._write_block(frame, piece, spared)

    def _spared(self, hidden: frozenset[int] | None) -> NDArray[np.bool_]:
        """Return for each label whether its points keep their values."""
        if hidden is None:
            return self.state.locked
        spared = self.state.locked | self.state.hidden
        spared[list(hidden)] = True
        return spared

    def _write_block(self, frame: int, piece: BlockWrite, spared: NDArray[np.bool_]) -> None:
        words = self.words((frame, LABELS, piece.block), piece.indices)
        shown = visible(words, self.exists)
        label = (shown & LABEL_BITS).astype(np.intp)
        free = ~spared[label] & _may_change(piece.only, shown)
        if piece.living is not None:
            deletion = self.words((frame, DELETION, piece.block), piece.indices)
            free &= ((deletion & DELETED_BIT) == 0) == piece.living
        values = words & VALUE_BITS
        if piece.label is not None:
            gains = free & self.state.locked[piece.label.astype(np.intp)]
            if gains.any():
                raise locked_error(self.palette, int(piece.label[gains][0]))
            values = (values & ~LABEL_BITS) | piece.label
        if piece.came is not None:
            values = (values & ~(PROVENANCE_BITS | CONFIDENCE_BITS)) | piece.came
        stamp = written_by(self.revision)
        indices = piece.indices[free]
        if piece.label is not None or piece.came is not None:
            self.put((frame, LABELS, piece.block), indices, words[free], values[free] | stamp)
        if piece.deleted is not None:
            place = (frame, DELETION, piece.block)
            after = (piece.deleted[free] << DELETED_SHIFT) | stamp
            self.put(place, indices, self.words(place, indices), after)

    def put(self, place: Place, indices: NDArray[np.int64], before: States, after: States) -> None:
        """Set words; ``before`` are the current ones, including this draft's changes so far."""
        if not len(indices):
            return
        earlier = self.changes.get(place)
        if earlier is None:
            self.changes.put(place, Change(indices, before, after))
            return
        both = np.union1d(earlier.indices, indices)
        old, new = np.searchsorted(both, earlier.indices), np.searchsorted(both, indices)
        merged = Change(both, np.empty(len(both), np.uint64), np.empty(len(both), np.uint64))
        merged.before[new] = before
        merged.before[old] = earlier.before  # before the edit, not before this part
        merged.after[old] = earlier.after
        merged.after[new] = after
        self.changes.put(place, merged)

    def clear_label(self, label: int) -> None:
        """Remove a label from all points that hold it, including hidden points."""
        stamp = written_by(self.revision)
        for frame, block, indices in holders(self.connection, self.state, label):
            place = (frame, LABELS, block)
            words = self.words(place, indices)
            self.put(place, indices, words, np.full(len(indices), stamp))

    def give_label(self, label: int, to: int) -> None:
        """Give all points that hold ``label``, including hidden points, the label ``to``."""
        stamp = written_by(self.revision)
        for frame, block, indices in holders(self.connection, self.state, label):
            place = (frame, LABELS, block)
            words = self.words(place, indices)
            kept = words & VALUE_BITS & ~LABEL_BITS
            self.put(place, indices, words, kept | np.uint64(to) | stamp)

    def foreign_writers(self) -> NDArray[np.uint64]:
        """Return the distinct revisions that wrote the points it changes."""
        found = [np.unique(change.before >> WRITER_SHIFT) for change in self.changes.values()]
        writers = np.unique(np.concatenate(found)) if found else np.empty(0, np.uint64)
        return writers[writers > 0]


def _may_change(only: str, shown: States) -> NDArray[np.bool_]:
    """Return the mask of the shown words that a Write's ``only`` allows to change."""
    label, came = shown & LABEL_BITS, provenance_of(shown)
    rules: dict[str, Callable[[], Any]] = {
        "any": lambda: np.ones(len(shown), np.bool_),
        "unlabeled": lambda: label == 0,
        "labeled": lambda: label != 0,
        "not_painted": lambda: came != PAINTED,
        "predictable": lambda: (came == PREDICTED) | ((label == 0) & (came != PAINTED)),
    }
    return np.asarray(rules[only]())


def holders(
    connection: Connection, state: SequenceState, label: int
) -> Iterator[tuple[int, int, NDArray[np.int64]]]:
    """Yield frame, block and its points that hold ``label``, including deleted points."""
    for frame, block in blocks_holding(state, {label}):
        found = holding(connection, state, frame, block, {label})
        if len(found):
            yield frame, block, found


def blocks_holding(state: SequenceState, labels: set[int]) -> Iterator[tuple[int, int]]:
    """Yield frame and block of points that may hold one of ``labels``, in order."""
    frames = {
        frame for (frame, label), count in state.counts.items() if label in labels and count[2]
    }
    for frame in sorted(frames):
        for block in range(-(-state.frame_points(frame) // BLOCK)):
            yield frame, block


def holding(
    connection: Connection, state: SequenceState, frame: int, block: int, labels: set[int]
) -> NDArray[np.int64]:
    """Return the points of a block that hold one of ``labels``, including deleted points."""
    states = state.block(connection, (frame, LABELS, block)).states
    if states is None:
        return np.empty(0, np.int64)
    return np.flatnonzero(np.isin(states & LABEL_BITS, np.fromiter(labels, np.uint64)))


def match_sorted(
    where: NDArray[np.int64], what: NDArray[np.int64]
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return the positions in sorted ``where`` of members of sorted ``what``, and their mask."""
    at = np.searchsorted(where, what)
    at[at == len(where)] = 0
    mine = where[at] == what if len(where) else np.zeros(len(what), np.bool_)
    return at[mine], mine
