"""What changes mean for those who look: deltas per frame, and counts per frame and label."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection

from pointbrush.labels.blocks import Place
from pointbrush.labels.draft import Draft, holders, match_sorted
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
from pointbrush.labels.types import PAINTED, Delta

Indices = NDArray[np.int64]


@dataclass(slots=True, eq=False)
class Effect:
    """``changed`` points, their values now by frame, and the counts that are new."""

    changed: int = 0
    frames: dict[int, Delta] = field(default_factory=dict)
    counts: dict[FrameLabel, Count] = field(default_factory=dict)


def effect_of(draft: Draft) -> Effect:
    """What committing ``draft`` changes for those who look."""
    state, connection = draft.state, draft.connection
    exists = draft.exists
    turned = [n for n, label in draft.labels.items() if (label is not None) != state.exists[n]]
    effect = Effect()
    pieces: dict[int, list[Delta]] = {}
    turns: dict[int, list[tuple[States, States]]] = {}
    for (frame, block), indices in _touched(connection, state, draft.changes, turned).items():
        before, after = _both_layers(connection, state, draft.changes, frame, block, indices)
        turns.setdefault(frame, []).append((before, after))
        shown = visible(after, exists)
        differs = visible(before, state.exists) != shown
        if differs.any():
            first = block * BLOCK
            pieces.setdefault(frame, []).append(_delta(indices[differs] + first, shown[differs]))
    for frame, pairs in turns.items():
        before, after = (np.concatenate(column) for column in zip(*pairs, strict=True))
        _count(effect.counts, state, frame, before, after)
    effect.frames = {frame: _joined(deltas) for frame, deltas in pieces.items()}
    effect.changed = sum(len(delta) for delta in effect.frames.values())
    return effect


def deltas_of(
    connection: Connection,
    state: SequenceState,
    changes: Mapping[Place, Change],
    labels: Iterable[int],
) -> dict[int, Delta]:
    """Deltas of an edit that ``state`` already contains, from its journal entry.

    ``labels``: palette entries it changed; points that hold them are included, for whether
    they are seen may have changed.
    """
    pieces: dict[int, list[Delta]] = {}
    for (frame, block), indices in _touched(connection, state, changes, labels).items():
        before, after = _both_layers(connection, state, changes, frame, block, indices)
        held = np.isin(label_of(after), list(labels))
        differs = (before != after) | held
        if differs.any():
            shown = visible(after, state.exists)[differs]
            pieces.setdefault(frame, []).append(_delta(indices[differs] + block * BLOCK, shown))
    return {frame: _joined(deltas) for frame, deltas in pieces.items()}


def labels_in(changes: Mapping[Place, Change], frames: Mapping[int, Delta]) -> set[FrameLabel]:
    """Frames and labels whose counts an edit may have changed."""
    found: set[FrameLabel] = set()
    for (frame, layer, _), change in changes.items():
        if layer == LABELS:
            words = np.concatenate([change.before, change.after])
            found.update((frame, label) for label in np.unique(label_of(words)).tolist())
    for frame, delta in frames.items():
        found.update((frame, label) for label in np.unique(delta.label).tolist())
    return {key for key in found if key[1]}


def _touched(
    connection: Connection,
    state: SequenceState,
    changes: Mapping[Place, Change],
    labels: Iterable[int],
) -> dict[tuple[int, int], Indices]:
    touched: dict[tuple[int, int], Indices] = {}

    def add(frame: int, block: int, indices: Indices) -> None:
        earlier = touched.get((frame, block))
        touched[frame, block] = indices if earlier is None else np.union1d(earlier, indices)

    for (frame, _, block), change in changes.items():
        add(frame, block, change.indices)
    for label in labels:
        for frame, block, indices in holders(connection, state, label):
            add(frame, block, indices)
    return dict(sorted(touched.items()))


def _both_layers(
    connection: Connection,
    state: SequenceState,
    changes: Mapping[Place, Change],
    frame: int,
    block: int,
    indices: Indices,
) -> tuple[States, States]:
    """Value bits of both layers together, before and after."""
    before = np.zeros(len(indices), np.uint64)
    after = np.zeros(len(indices), np.uint64)
    for layer, bits in ((LABELS, VALUE_BITS & ~DELETED_BIT), (DELETION, DELETED_BIT)):
        words = state.block(connection, (frame, layer, block)).words(indices)
        change = changes.get((frame, layer, block))
        before_words, after_words = words, words
        if change is not None:
            at, mine = match_sorted(change.indices, indices)
            before_words, after_words = words.copy(), words.copy()
            before_words[mine] = change.before[at]
            after_words[mine] = change.after[at]
        before |= before_words & bits
        after |= after_words & bits
    return before, after


def _count(
    counts: dict[FrameLabel, Count],
    state: SequenceState,
    frame: int,
    before: States,
    after: States,
) -> None:
    differs = before != after
    for values, sign in ((before[differs], -1), (after[differs], 1)):
        for label, tally in tally_labels(values):
            key = (frame, label)
            old = counts.get(key) or state.counts.get(key, NONE)
            new = tuple(o + sign * t for o, t in zip(old, tally, strict=True))
            counts[key] = (new[0], new[1], new[2])


def tally_labels(values: States) -> Iterable[tuple[int, Count]]:
    """For each label in ``values`` (both layers): points, painted ones, all that hold it."""
    values = values[(values & LABEL_BITS) != 0]
    if not len(values):
        return
    present, at = np.unique(label_of(values), return_inverse=True)
    alive = ~deleted_of(values)
    painted = alive & (provenance_of(values) == PAINTED)
    n = len(present)
    columns = (
        np.bincount(at[alive], minlength=n),
        np.bincount(at[painted], minlength=n),
        np.bincount(at, minlength=n),
    )
    for label, points, drawn, held in zip(present.tolist(), *map(list, columns), strict=True):
        yield label, (int(points), int(drawn), int(held))


def _delta(indices: Indices, shown: States) -> Delta:
    return Delta(
        indices.astype(np.uint32), label_of(shown), provenance_of(shown), deleted_of(shown)
    )


def _joined(deltas: list[Delta]) -> Delta:
    if len(deltas) == 1:
        return deltas[0]
    return Delta(
        np.concatenate([delta.indices for delta in deltas]),
        np.concatenate([delta.label for delta in deltas]),
        np.concatenate([delta.provenance for delta in deltas]),
        np.concatenate([delta.deleted for delta in deltas]),
    )
