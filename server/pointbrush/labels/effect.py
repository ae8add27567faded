"""Effect of changes for viewers: deltas per frame, and counts per frame and label.

They are computed block by block, so that an edit of a whole scan needs the memory of a few blocks.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection

from pointbrush.labels.blocks import Place
from pointbrush.labels.draft import Draft, blocks_holding, holding, match_sorted
from pointbrush.labels.packing import (
    BLOCK,
    DELETED_BIT,
    DELETION,
    LABEL_BITS,
    LABELS,
    VALUE_BITS,
    Change,
    States,
    deleted_of,
    label_of,
    provenance_of,
)
from pointbrush.labels.state import NONE, Count, FrameLabel, SequenceState, visible
from pointbrush.labels.types import PAINTED, Delta, Deltas

Indices = NDArray[np.int64]

LISTED_POINTS = 5_000_000
"""Limit of changed points that an edit lists; further frames are announced without points."""


@dataclass(slots=True, eq=False)
class Effect:
    """Number of changed points, their new values by frame, and the new counts."""

    changed: int = 0
    frames: Deltas = field(default_factory=dict)
    counts: dict[FrameLabel, Count] = field(default_factory=dict)


@dataclass(slots=True, eq=False)
class _Listing:
    """Collects deltas in the order of frames and blocks."""

    changed: int = 0
    _listed: int = 0
    _pieces: dict[int, list[Delta] | None] = field(default_factory=dict)

    def add(self, frame: int, piece: Delta) -> None:
        """Add changed points of a frame."""
        self.changed += len(piece)
        self._listed += len(piece)
        pieces = self._pieces.setdefault(frame, [])
        if pieces is None:
            return
        if self._listed <= LISTED_POINTS:
            pieces.append(piece)
            return
        self._listed -= sum(map(len, pieces)) + len(piece)
        self._pieces[frame] = None

    def frames(self) -> Deltas:
        """Return the delta of each frame; None for a frame with too many points."""
        return {
            frame: None if pieces is None else _joined(pieces)
            for frame, pieces in self._pieces.items()
        }


def effect_of(draft: Draft) -> Effect:
    """Compute the changes that committing ``draft`` makes for viewers."""
    state, exists = draft.state, draft.exists
    turned = {n for n, label in draft.labels.items() if (label is not None) != state.exists[n]}
    effect, listing = Effect(), _Listing()
    for block in _touched(draft.connection, state, draft.changes, turned):
        _count(effect.counts, state, block)
        shown = visible(block.after, exists)
        differs = visible(block.before, state.exists) != shown
        if differs.any():
            listing.add(block.frame, block.delta(differs, shown))
    effect.frames, effect.changed = listing.frames(), listing.changed
    return effect


def deltas_of(
    connection: Connection,
    state: SequenceState,
    changes: Mapping[Place, Change],
    labels: Iterable[int],
) -> Deltas:
    """Return the deltas of an edit already in ``state``, from its journal entry.

    ``labels``: palette entries it changed; points that hold them are included, as their visibility
    may have changed.
    """
    chosen, listing = set(labels), _Listing()
    for block in _touched(connection, state, changes, chosen):
        differs = block.before != block.after
        if chosen:
            differs |= np.isin(label_of(block.after), list(chosen))
        if differs.any():
            listing.add(block.frame, block.delta(differs, visible(block.after, state.exists)))
    return listing.frames()


def labels_in(changes: Mapping[Place, Change], frames: Deltas) -> set[FrameLabel]:
    """Return the frames and labels with counts that an edit may have changed."""
    found: set[FrameLabel] = set()
    for (frame, layer, _), change in changes.items():
        if layer == LABELS:
            for words in (change.before, change.after):
                found.update((frame, label) for label in np.unique(label_of(words)).tolist())
    for frame, delta in frames.items():
        if delta is not None:
            found.update((frame, label) for label in np.unique(delta.label).tolist())
    return {key for key in found if key[1]}


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    """Points of one block affected by an edit: value bits of both layers, before and after."""

    frame: int
    number: int
    indices: Indices
    before: States
    after: States

    def delta(self, which: NDArray[np.bool_], shown: States) -> Delta:
        """Return the points that ``which`` marks, with their ``shown`` values."""
        indices = self.indices[which] + self.number * BLOCK
        values = shown[which]
        return Delta(
            indices.astype(np.uint32), label_of(values), provenance_of(values), deleted_of(values)
        )


def _touched(
    connection: Connection,
    state: SequenceState,
    changes: Mapping[Place, Change],
    labels: set[int],
) -> Iterator[_Block]:
    """Yield the blocks with changes or with points that hold one of ``labels``, in order."""
    holders = set(blocks_holding(state, labels)) if labels else set()
    for frame, block in sorted({(frame, block) for frame, _, block in changes} | holders):
        layers = {layer: changes.get((frame, layer, block)) for layer in (LABELS, DELETION)}
        about = [change.indices for change in layers.values() if change is not None]
        if (frame, block) in holders:
            about.append(holding(connection, state, frame, block, labels))
        indices = about[0] if len(about) == 1 else np.unique(np.concatenate(about))
        if not len(indices):
            continue
        before, after = _both_layers(connection, state, layers, frame, block, indices)
        yield _Block(frame, block, indices, before, after)


def _both_layers(
    connection: Connection,
    state: SequenceState,
    changes: Mapping[int, Change | None],
    frame: int,
    block: int,
    indices: Indices,
) -> tuple[States, States]:
    """Return the combined value bits of both layers, before and after."""
    before = np.zeros(len(indices), np.uint64)
    after = np.zeros(len(indices), np.uint64)
    for layer, bits in ((LABELS, VALUE_BITS & ~DELETED_BIT), (DELETION, DELETED_BIT)):
        words = state.block(connection, (frame, layer, block)).words(indices)
        change = changes[layer]
        before_words, after_words = words, words
        if change is not None:
            at, mine = match_sorted(change.indices, indices)
            before_words, after_words = words.copy(), words.copy()
            before_words[mine] = change.before[at]
            after_words[mine] = change.after[at]
        before |= before_words & bits
        after |= after_words & bits
    return before, after


def _count(counts: dict[FrameLabel, Count], state: SequenceState, block: _Block) -> None:
    differs = block.before != block.after
    for values, sign in ((block.before[differs], -1), (block.after[differs], 1)):
        for label, tally in tally_labels(values):
            key = (block.frame, label)
            old = counts.get(key) or state.counts.get(key, NONE)
            new = tuple(o + sign * t for o, t in zip(old, tally, strict=True))
            counts[key] = (new[0], new[1], new[2])


def tally_labels(values: States) -> Iterable[tuple[int, Count]]:
    """Yield for each label in ``values`` (both layers) its visible, painted and total points."""
    values = values[(values & LABEL_BITS) != 0]
    if not len(values):
        return
    labels = label_of(values)
    alive = ~deleted_of(values)
    held = np.bincount(labels)
    points = np.bincount(labels[alive], minlength=len(held))
    painted = alive & (provenance_of(values) == PAINTED)
    drawn = np.bincount(labels[painted], minlength=len(held))
    for label in np.flatnonzero(held).tolist():
        yield label, (int(points[label]), int(drawn[label]), int(held[label]))


def _joined(deltas: list[Delta]) -> Delta:
    if len(deltas) == 1:
        return deltas[0]
    return Delta(
        np.concatenate([delta.indices for delta in deltas]),
        np.concatenate([delta.label for delta in deltas]),
        np.concatenate([delta.provenance for delta in deltas]),
        np.concatenate([delta.deleted for delta in deltas]),
    )
