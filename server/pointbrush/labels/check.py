"""Check the consistency of the database, and rebuild the tables derived from the journal.

All tables are compared with a replay of the journal; snapshots, counts, palette, tracks, boxes and
frame changes can be rebuilt from it.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Generator, Iterator, Set
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from sqlalchemy import ColumnElement, Connection, Table, and_, delete, func, insert, select
from sqlalchemy.sql.base import ReadOnlyColumnCollection

from pointbrush.database.schema import (
    IN_FORCE,
    boxes,
    counts,
    edit_blocks,
    edit_labels,
    edit_tracks,
    edits,
    frame_changes,
    labels,
    snapshots,
    tracks,
)
from pointbrush.labels.blocks import Place, block_size
from pointbrush.labels.boxes import journal as box_journal
from pointbrush.labels.classes import palette
from pointbrush.labels.classes.palette import FIELDS
from pointbrush.labels.effect import tally_labels
from pointbrush.labels.packing import (
    BLOCK,
    DELETED_BIT,
    DELETION,
    LABELS,
    VALUE_BITS,
    States,
    decode_change,
    decode_states,
    encode_states,
    writer_of,
)
from pointbrush.labels.state import NONE, FrameLabel, SequenceState

ROWS = 500
"""Rows written at once."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A fault, in a sentence; ``derived``: it can be repaired from the journal."""

    text: str
    derived: bool


def check(connection: Connection, state: SequenceState) -> list[Finding]:
    """Return the faults of a sequence; nothing is repaired."""
    tally = Tally(connection, state)
    return [
        *_check_numbers(connection, state),
        *tally.findings(),
        *_check_counts(connection, state, tally.counts),
        *_check_palette(connection, state),
        *_check_tracks(connection, state),
        *_check_boxes(connection, state),
        *_check_frame_changes(connection, state),
    ]


def _check_numbers(connection: Connection, state: SequenceState) -> Iterator[Finding]:
    query = select(func.count(), func.min(edits.c.revision), func.max(edits.c.revision))
    found, first, last = connection.execute(query.where(edits.c.sequence == state.number)).one()
    expected = (state.revision, 1, state.revision) if state.revision else (0, None, None)
    if (found, first, last) != expected:
        yield Finding(
            f"journal: expected revisions 1 to {state.revision}, got {found} edits from "
            f"{first} to {last}",
            derived=False,
        )


class Tally:
    """Counts of labels by a replay of the journal, filled in by ``findings``."""

    def __init__(self, connection: Connection, state: SequenceState) -> None:
        self._connection, self._state = connection, state
        self.counts: dict[FrameLabel, tuple[int, ...]] = {}

    def findings(self) -> Iterator[Finding]:
        """Yield the faults of the journal of points and its snapshots, block by block."""
        connection, state = self._connection, self._state
        in_force = set(
            connection.execute(
                select(edits.c.revision).where(
                    edits.c.sequence == state.number, edits.c.state.in_(IN_FORCE)
                )
            ).scalars()
        )
        table = edit_blocks.c
        columns = (table.frame, table.block, table.layer)
        query = select(*columns).where(table.sequence == state.number)
        places = connection.execute(query.distinct().order_by(*columns)).all()
        for (frame, block), group in groupby(places, lambda row: (row.frame, row.block)):
            values = np.zeros(1, np.uint64)
            for _, _, layer in group:
                states = yield from _check_place(connection, state, (frame, layer, block), in_force)
                bits = DELETED_BIT if layer == DELETION else VALUE_BITS & ~DELETED_BIT
                values = values | (states & bits)
            for label, found in tally_labels(values):
                old = self.counts.get((frame, label), NONE)
                self.counts[frame, label] = tuple(a + b for a, b in zip(old, found, strict=True))


def _check_place(
    connection: Connection, state: SequenceState, place: Place, in_force: set[int]
) -> Generator[Finding, None, States]:
    """Replay one place and compare its stored and cached states; return the states."""
    states = np.zeros(block_size(state.frame_points(place[0]), place[2]), np.uint64)
    yield from _replay(connection, state, place, states)
    stale = set(np.unique(writer_of(states)).tolist()) - in_force - {0}
    if stale:
        shown = sorted(stale)[:10]
        yield Finding(f"{_where(place)}: shows edits that are not in force: {shown}", derived=False)
    cached = state.cached(place)
    if cached is not None and not np.array_equal(cached.words(np.arange(len(states))), states):
        yield Finding(f"{_where(place)}: memory differs from the journal", derived=True)
    return states


def _replay(
    connection: Connection, state: SequenceState, place: Place, states: States
) -> Iterator[Finding]:
    """Replay a place's journal into ``states``, comparing with its snapshot on the way."""
    snapshot = at(snapshots.c, state.number, place)
    kept = connection.execute(
        select(snapshots.c.revision, snapshots.c.data).where(snapshot)
    ).one_or_none()
    table = edit_blocks.c
    query = select(table.revision, table.data).where(at(table, state.number, place))
    rows = connection.execute(query.order_by(table.revision)).all()
    for number, (revision, data) in enumerate(rows):
        try:
            change = decode_change(data)
            if not np.array_equal(states[change.indices], change.before):
                broken = f"edit {revision} does not follow from those before it"
                yield Finding(f"{_where(place)}: {broken}", derived=False)
            states[change.indices] = change.after
        except (ValueError, IndexError, zlib.error) as error:
            broken = f"edit {revision} cannot be read: {error}"
            yield Finding(f"{_where(place)}: {broken}", derived=False)
        following = rows[number + 1].revision if number + 1 < len(rows) else state.revision + 1
        if kept is not None and revision <= kept.revision < following:
            yield from _compare_snapshot(place, kept.data, states)


def _compare_snapshot(place: Place, data: bytes, states: States) -> Iterator[Finding]:
    try:
        same = np.array_equal(decode_states(data), states)
    except (ValueError, zlib.error) as error:
        yield Finding(f"{_where(place)}: its snapshot cannot be read: {error}", derived=True)
        return
    if not same:
        yield Finding(f"{_where(place)}: its snapshot differs from the journal", derived=True)


def _check_counts(
    connection: Connection, state: SequenceState, tally: dict[FrameLabel, tuple[int, ...]]
) -> Iterator[Finding]:
    rows = connection.execute(select(counts).where(counts.c.sequence == state.number))
    kept = {(row.frame, row.label): (row.points, row.painted, row.held) for row in rows}
    for key in _sorted(kept.keys() | tally.keys()):
        if kept.get(key, NONE) != tally.get(key, NONE):
            yield Finding(
                f"counts: frame {key[0]}, label {key[1]}: expected {tally.get(key, NONE)}, "
                f"got {kept.get(key, NONE)}",
                derived=True,
            )


def _check_palette(connection: Connection, state: SequenceState) -> Iterator[Finding]:
    of_sequence = edit_labels.c.sequence == state.number
    known = set(
        connection.execute(select(edit_labels.c.label).where(of_sequence).distinct()).scalars()
    )
    kept = set(
        connection.execute(select(labels.c.id).where(labels.c.sequence == state.number)).scalars()
    )
    folded = palette.fold(connection, state.number, known | kept, state.classes)
    for label_id, label in folded.items():
        if label != state.palette.get(label_id):
            got = state.palette.get(label_id)
            yield Finding(f"palette: label {label_id}: expected {label}, got {got}", derived=True)


def expected_tracks(connection: Connection, state: SequenceState) -> dict[FrameLabel, str]:
    """Return the tracks set by the edits in force, as JSON by frame and label."""
    query = (
        select(edit_tracks.c.frame, edit_tracks.c.label, edit_tracks.c.data)
        .join(
            edits,
            and_(
                edits.c.sequence == edit_tracks.c.sequence,
                edits.c.revision == edit_tracks.c.revision,
            ),
        )
        .where(edits.c.sequence == state.number, edits.c.state.in_(IN_FORCE))
        .order_by(edit_tracks.c.revision)
    )
    return {(frame, label): data for frame, label, data in connection.execute(query)}


def _check_tracks(connection: Connection, state: SequenceState) -> Iterator[Finding]:
    expected = expected_tracks(connection, state)
    rows = connection.execute(select(tracks).where(tracks.c.sequence == state.number))
    kept = {(row.frame, row.label): row.data for row in rows}
    for frame, label in _sorted(expected.keys() | kept.keys()):
        wanted, found = expected.get((frame, label)), kept.get((frame, label))
        if (wanted and json.loads(wanted)) != (found and json.loads(found)):
            what = f"tracks: frame {frame}, label {label} differs from the journal"
            yield Finding(what, derived=True)


def _check_boxes(connection: Connection, state: SequenceState) -> Iterator[Finding]:
    expected = box_journal.fold(connection, state.number)
    kept = box_journal.stored(connection, state.number)
    for box in _sorted(expected.keys() | kept.keys()):
        if expected.get(box) != kept.get(box):
            yield Finding(f"boxes: box {box} differs from the journal", derived=True)


def expected_frame_changes(connection: Connection, state: SequenceState) -> dict[int, int]:
    """Return the revision of each frame's last change, from the journal."""
    query = select(edits.c.revision, edits.c.frames).where(edits.c.sequence == state.number)
    expected: dict[int, int] = {}
    for revision, frames in connection.execute(query.order_by(edits.c.revision)):
        expected.update(dict.fromkeys(json.loads(frames), revision))
    return expected


def _check_frame_changes(connection: Connection, state: SequenceState) -> Iterator[Finding]:
    expected = expected_frame_changes(connection, state)
    table = frame_changes.c
    query = select(table.frame, table.revision).where(table.sequence == state.number)
    kept = {row.frame: row.revision for row in connection.execute(query)}
    for frame in _sorted(expected.keys() | kept.keys()):
        wanted = expected.get(frame, 0)
        for where, found in (("database", kept), ("memory", state.changed)):
            if found.get(frame, 0) != wanted:
                what = (
                    f"last change of frame {frame}: expected revision {wanted}, "
                    f"the {where} has {found.get(frame, 0)}"
                )
                yield Finding(what, derived=True)


def _sorted(keys: Set[Any]) -> list[Any]:
    """Sort keys of rows; damaged rows have keys of any type."""
    try:
        return sorted(keys)
    except TypeError:
        return sorted(keys, key=repr)


def at(table: ReadOnlyColumnCollection[str, Any], number: int, place: Place) -> ColumnElement[bool]:
    """Return the condition that rows of a table belong to one place of sequence ``number``."""
    return and_(
        table.sequence == number,
        table.frame == place[0],
        table.layer == place[1],
        table.block == place[2],
    )


def _where(place: Place) -> str:
    layer = "labels" if place[1] == LABELS else "deletion"
    return f"frame {place[0]}, points from {place[2] * BLOCK}, {layer}"


def repair(connection: Connection, state: SequenceState) -> tuple[list[str], list[str]]:
    """Rebuild tables of a sequence that disagree with its journal, in the caller's transaction.

    Returns the faults that are repaired and the faults that cannot be.  If the journal itself is
    damaged, nothing is rebuilt, as the derived tables may hold the only remaining data.
    """
    found = check(connection, state)
    lost = [finding.text for finding in found if not finding.derived]
    derived = [finding.text for finding in found if finding.derived]
    if lost or not derived:
        return [], lost + derived
    _snapshots(connection, state)
    _replace(connection, state, counts, _count_rows(connection, state))
    _replace(connection, state, labels, _label_rows(connection, state))
    _replace(connection, state, tracks, _track_rows(connection, state))
    _replace(connection, state, boxes, _box_rows(connection, state))
    _replace(connection, state, frame_changes, _frame_rows(connection, state))
    return derived, []


def _replace(
    connection: Connection, state: SequenceState, table: Table, rows: list[dict[str, Any]]
) -> None:
    connection.execute(delete(table).where(table.c.sequence == state.number))
    for first in range(0, len(rows), ROWS):
        connection.execute(
            insert(table), [{"sequence": state.number, **row} for row in rows[first : first + ROWS]]
        )


def _snapshots(connection: Connection, state: SequenceState) -> None:
    """Rebuild each block's snapshot from the current states, one block at a time."""
    table = snapshots.c
    kept = select(table.frame, table.layer, table.block).where(table.sequence == state.number)
    for place in sorted(tuple(row) for row in connection.execute(kept).all()):
        frame, layer, block = place
        is_block = at(table, state.number, place)
        states = _replayed(connection, state, place)
        connection.execute(delete(snapshots).where(is_block))
        connection.execute(
            insert(snapshots),
            {
                "sequence": state.number,
                "frame": frame,
                "layer": layer,
                "block": block,
                "revision": state.revision,
                "data": encode_states(states),
            },
        )


def _replayed(connection: Connection, state: SequenceState, place: Place) -> States:
    states = np.zeros(block_size(state.frame_points(place[0]), place[2]), np.uint64)
    table = edit_blocks.c
    query = select(table.data).where(at(table, state.number, place)).order_by(table.revision)
    for data in connection.execute(query).scalars():
        change = decode_change(data)
        states[change.indices] = change.after
    return states


def _count_rows(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    tally = Tally(connection, state)
    list(tally.findings())
    return [
        {"frame": frame, "label": label, "points": points, "painted": painted, "held": held}
        for (frame, label), (points, painted, held) in tally.counts.items()
    ]


def _label_rows(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    of_sequence = edit_labels.c.sequence == state.number
    known = (
        connection.execute(select(edit_labels.c.label).where(of_sequence).distinct())
        .scalars()
        .all()
    )
    folded = palette.fold(connection, state.number, known, state.classes)
    return [
        state.classes.stored({"id": label.id, **{name: getattr(label, name) for name in FIELDS}})
        for label in folded.values()
        if label is not None
    ]


def _track_rows(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    return [
        {"frame": frame, "label": label, "data": data}
        for (frame, label), data in expected_tracks(connection, state).items()
    ]


def _box_rows(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    return [
        {"id": box, "label": fields["label"], "data": json.dumps(fields)}
        for box, fields in box_journal.fold(connection, state.number).items()
        if fields is not None
    ]


def _frame_rows(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    changed = expected_frame_changes(connection, state)
    return [{"frame": frame, "revision": revision} for frame, revision in changed.items()]
