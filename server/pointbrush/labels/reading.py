"""Read labels: values of points, counts, tracks, the history, and the view of a stroke."""

from __future__ import annotations

import json
import time
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, Row, and_, distinct, func, select

from pointbrush.database import schema
from pointbrush.database.database import CHUNK
from pointbrush.database.schema import edits
from pointbrush.errors import BadInputError
from pointbrush.labels import journal
from pointbrush.labels.open_recordings import OpenRecordings
from pointbrush.labels.packing import (
    BLOCK,
    DELETION,
    LABELS,
    confidence_of,
    deleted_of,
    label_of,
    provenance_of,
)
from pointbrush.labels.state import NotInMemoryError, SequenceState, visible
from pointbrush.labels.types import EditInfo, FrameValues, GapError, Label, Progress
from pointbrush.labels.writes import require_paintable
from pointbrush.ranges import by_block
from pointbrush.values.kinds import time_of

MOST_NAMED = 1_000
"""Limit of sequences named in a statement; for more, the statement selects all."""
HISTORY_LIMIT = 1_000
"""Limit of lines in one response."""
SINCE_EDITS = 2_000
SINCE_POINTS = 5_000_000
"""Limits above which sending whole annotations is shorter than sending the changes."""
FRESH_SECONDS = 0.02
"""Minimum interval between two queries for a newer revision."""


def values(
    connection: Connection | None,
    state: SequenceState,
    frame: int,
    first: int,
    count: int | None,
) -> FrameValues:
    """Return the annotation of points [first, first + count) of a frame, if they exist.

    Raises NotInMemoryError if a block must be read without a ``connection``.
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
        np.zeros(n, np.uint8),
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
                result.confidence[into] = confidence_of(shown)
    return result


def at(
    connection: Connection | None, state: SequenceState, frame: int, numbers: NDArray[np.int64]
) -> FrameValues:
    """Return the annotation of sorted point ``numbers`` (n,) of a frame; raises like ``values``."""
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
        confidence_of(shown),
        state.revision,
        state.changed.get(frame, 0),
    )


def counts(state: SequenceState) -> dict[tuple[int, int], tuple[int, int]]:
    """Return the number of points, and of painted points, by frame and label."""
    return {
        key: (points, painted)
        for key, (points, painted, _) in state.counts.items()
        if points and key[1] in state.palette
    }


def tracks(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    """Return the tracks of existing labels, by frame and label."""
    table = schema.tracks.c
    query = (
        select(table.label, table.data)
        .where(table.sequence == state.number)
        .order_by(table.frame, table.label)
    )
    return [json.loads(data) for label, data in connection.execute(query) if label in state.palette]


def progress(connection: Connection, wanted: Collection[str] | None = None) -> dict[str, Progress]:
    """Count labelled frames and labels of ``wanted`` sequences at least; None: all."""
    counts, palette, sequences = schema.counts, schema.labels, schema.sequences
    labels = (
        select(sequences.c.id, func.count())
        .join(palette, palette.c.sequence == sequences.c.number)
        .where(sequences.c.deleted.is_(None))
        .group_by(sequences.c.id)
    )
    done = (
        select(
            sequences.c.id, func.count(distinct(counts.c.frame)), func.count(distinct(palette.c.id))
        )
        .join(counts, counts.c.sequence == sequences.c.number)
        .join(palette, (palette.c.sequence == counts.c.sequence) & (palette.c.id == counts.c.label))
        .where(sequences.c.deleted.is_(None), counts.c.points > 0)
        .group_by(sequences.c.id)
    )
    last = (edits.c.sequence == sequences.c.number) & (edits.c.revision == sequences.c.revision)
    changed = (
        select(sequences.c.id, edits.c.time).join(edits, last).where(sequences.c.deleted.is_(None))
    )
    if wanted is not None and len(wanted) <= MOST_NAMED:
        labels, done, changed = (
            query.where(sequences.c.id.in_(wanted)) for query in (labels, done, changed)
        )
    found = {name: (frames, used) for name, frames, used in connection.execute(done)}
    created = {row[0]: row[1] for row in connection.execute(labels)}
    times = {row.id: row.time for row in connection.execute(changed)}
    return {
        str(name): Progress(*found.get(name, (0, 0)), created.get(name, 0), times.get(name))
        for name in created.keys() | times.keys()
    }


def having(connection: Connection, wanted: Mapping[str, str]) -> set[str]:
    """Return the live sequences of ``wanted`` with an edit of the id there in their journal."""
    pairs, found = list(wanted.items()), set()
    sequences = schema.sequences.c
    for start in range(0, len(pairs), CHUNK):
        part = dict(pairs[start : start + CHUNK])
        rows = connection.execute(
            select(sequences.id, edits.c.id.label("edit"))
            .join(edits, edits.c.sequence == sequences.number)
            .where(sequences.deleted.is_(None), edits.c.id.in_(part.values()))
        )
        found |= {str(row.id) for row in rows if part.get(row.id) == row.edit}
    return found


def history_lines(
    connection: Connection, number: int, before: int | None, limit: int, after: int | None = None
) -> list[EditInfo]:
    """Return lines of the history, newest first, or lines ``after`` a revision, oldest first.

    Raises BadInputError for a limit below 1.
    """
    if limit < 1:
        raise BadInputError(f"limit: expected 1 or more, got {limit}")
    target = edits.alias()
    query = (
        select(edits, target.c.id.label("target_id"))
        .join(
            target,
            and_(target.c.sequence == edits.c.sequence, target.c.revision == edits.c.target),
            isouter=True,
        )
        .where(edits.c.sequence == number)
    )
    if before is not None:
        query = query.where(edits.c.revision < before)
    order = edits.c.revision.desc()
    if after is not None:
        query, order = query.where(edits.c.revision > after), edits.c.revision.asc()
    rows = connection.execute(query.order_by(order).limit(min(limit, HISTORY_LIMIT)))
    return [edit_info(row, row.target_id) for row in rows]


def authors(connection: Connection, number: int) -> set[str]:
    """Return the accounts that edited the sequence."""
    query = select(edits.c.author).where(edits.c.sequence == number).distinct()
    return set(connection.execute(query).scalars())


def edit_info(row: Row[Any], target: str | None = None) -> EditInfo:
    """Return a row as a line of the history."""
    return EditInfo(
        id=row.id,
        revision=row.revision,
        author=row.author,
        time=time_of(row.time),
        kind=row.kind,
        summary=row.summary,
        points=row.points,
        frames=tuple(json.loads(row.frames)),
        undone=row.state in (schema.UNDONE, schema.DROPPED),
        target=target,
    )


def stacks(ask: journal.Ask, number: int, author: str) -> tuple[EditInfo | None, EditInfo | None]:
    """Return the next edits for ``author``'s undo and redo."""
    last = journal.top_of_stack(ask, number, author, schema.ACTIVE)
    undone = journal.top_of_stack(ask, number, author, schema.UNDONE)
    return last and edit_info(last), undone and edit_info(undone)


def rows_to_resend(connection: Connection, state: SequenceState, revision: int) -> list[Row[Any]]:
    """Return rows after ``revision``, oldest first; raises GapError above the limits."""
    missed = state.revision - revision
    if not 0 <= missed <= SINCE_EDITS:
        raise GapError(
            f"revision: expected {max(0, state.revision - SINCE_EDITS)} to {state.revision}, "
            f"got {revision}"
        )
    after = and_(edits.c.sequence == state.number, edits.c.revision > revision)
    points = connection.execute(select(func.sum(edits.c.points)).where(after)).scalar() or 0
    if points > SINCE_POINTS:
        raise GapError(f"revision: {points:,} points changed since {revision}")
    return journal.rows_since(connection, state.number, revision, SINCE_EDITS)


class View:
    """Labels of a sequence in the memory of this process, with its own commits; thread-safe.

    Other processes' commits are visible after ``look``, which a commit of an edit includes.
    """

    def __init__(self, open_recordings: OpenRecordings, sequence: str) -> None:
        """``sequence`` must be up to date."""
        self._open_recordings, self._sequence = open_recordings, sequence
        self._looked = time.monotonic()

    def look(self) -> None:
        """Apply other processes' commits; raises NotFoundError, UnavailableError."""
        if time.monotonic() - self._looked > FRESH_SECONDS:
            with self._open_recordings.knowing(self._sequence):
                self._looked = time.monotonic()

    def values(self, frame: int, first: int, count: int | None) -> FrameValues:
        """Return the annotation of points [first, first + count) of a frame, if they exist."""
        try:
            with self._open_recordings.knowing(self._sequence, look=False) as state:
                return values(None, state, frame, first, count)
        except NotInMemoryError:
            with self._open_recordings.reading(self._sequence) as (connection, state):
                return values(connection, state, frame, first, count)

    def at(self, frame: int, numbers: NDArray[np.int64]) -> FrameValues:
        """Return the annotation of sorted point ``numbers`` (n,) of a frame."""
        try:
            with self._open_recordings.knowing(self._sequence, look=False) as state:
                return at(None, state, frame, numbers)
        except NotInMemoryError:
            with self._open_recordings.reading(self._sequence) as (connection, state):
                return at(connection, state, frame, numbers)

    def palette(self) -> dict[int, Label]:
        """Return the labels by id."""
        with self._open_recordings.knowing(self._sequence, look=False) as state:
            return state.palette

    def hidden(self) -> NDArray[np.bool_]:
        """Return for each label id 0..65535 whether the palette hides it."""
        with self._open_recordings.knowing(self._sequence, look=False) as state:
            return state.hidden

    def require_paintable(self, label: int, hidden: frozenset[int] | None = None) -> None:
        """Raise the errors of ``LabelStore.require_paintable``."""
        require_paintable(self.palette(), label, hidden)
