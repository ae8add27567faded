"""Reading the state: annotation values, counts, tracks."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, distinct, func, select

from pointbrush.errors import BadInputError
from pointbrush.labels import schema
from pointbrush.labels.packing import BLOCK, DELETION, LABELS, deleted_of, label_of, provenance_of
from pointbrush.labels.state import SequenceState, visible
from pointbrush.labels.types import FrameValues
from pointbrush.ranges import by_block


def values(
    connection: Connection | None,
    state: SequenceState,
    frame: int,
    first: int,
    count: int | None,
) -> FrameValues:
    """Annotation of points [first, first + count) of a frame, as far as it has them.

    Raises NotInMemoryError where a block must be read, and there is no ``connection``.
    """
    points = state.frame_points(frame)
    if first < 0 or (count is not None and count < 0):
        raise BadInputError(f"points: expected first and count of 0 or more, got {first}, {count}")
    stop = points if count is None else min(points, first + count)
    n = max(0, stop - first)
    result = FrameValues(
        np.zeros(n, np.uint16),
        np.zeros(n, np.uint8),
        np.zeros(n, np.bool_),
        state.revision,
        state.changed.get(frame, 0),
    )
    if n == 0:
        return result
    for layer in (LABELS, DELETION):
        start_block, last_block = first // BLOCK, (stop - 1) // BLOCK
        blocks = state.block_run(connection, frame, layer, start_block, last_block)
        for number, block in enumerate(blocks, start_block):
            if block.states is None:
                continue
            start, end = max(first, number * BLOCK), min(stop, (number + 1) * BLOCK)
            part = block.states[start - number * BLOCK : end - number * BLOCK]
            into = slice(start - first, end - first)
            if layer == DELETION:
                result.deleted[into] = deleted_of(part)
            else:
                shown = visible(part, state.exists)
                result.label[into] = label_of(shown)
                result.provenance[into] = provenance_of(shown)
    return result


def at(
    connection: Connection | None, state: SequenceState, frame: int, numbers: NDArray[np.int64]
) -> FrameValues:
    """Annotation of sorted point ``numbers`` (n,) of a frame; raises as ``values`` does."""
    words = {layer: np.empty(len(numbers), np.uint64) for layer in (LABELS, DELETION)}
    for first, mine in by_block(numbers, BLOCK):
        for layer, found in words.items():
            block = state.block(connection, (frame, layer, first // BLOCK))
            found[mine] = block.words(numbers[mine] - first)
    shown = visible(words[LABELS], state.exists)
    return FrameValues(
        label_of(shown),
        provenance_of(shown),
        deleted_of(words[DELETION]),
        state.revision,
        state.changed.get(frame, 0),
    )


def counts(state: SequenceState) -> dict[tuple[int, int], tuple[int, int]]:
    """For each frame and label that has any: points, and painted ones among them."""
    return {
        key: (points, painted)
        for key, (points, painted, _) in state.counts.items()
        if points and key[1] in state.palette
    }


def tracks(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    """Tracks of the labels that exist, by frame and label."""
    table = schema.tracks.c
    query = (
        select(table.label, table.data)
        .where(table.sequence == state.number)
        .order_by(table.frame, table.label)
    )
    return [json.loads(data) for label, data in connection.execute(query) if label in state.palette]


def labelled_frames(connection: Connection) -> dict[str, int]:
    """Count the frames with labelled points of each live sequence that has any."""
    counts, sequences = schema.counts, schema.sequences
    query = (
        select(sequences.c.id, func.count(distinct(counts.c.frame)))
        .join(counts, counts.c.sequence == sequences.c.number)
        .where(sequences.c.deleted.is_(None), counts.c.label > 0, counts.c.points > 0)
        .group_by(sequences.c.id)
    )
    return {str(name): int(frames) for name, frames in connection.execute(query)}
