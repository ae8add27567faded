"""Making anew what derives from the journal: snapshots, counts, palette, tracks, frame changes."""

from __future__ import annotations

from typing import Any

import numpy as np
from sqlalchemy import Connection, Table, delete, insert, select

from pointbrush.labels import check, palette
from pointbrush.labels.blocks import Place, block_size
from pointbrush.labels.packing import States, decode_change, encode_states
from pointbrush.labels.palette import FIELDS
from pointbrush.labels.schema import (
    counts,
    edit_blocks,
    edit_labels,
    frame_changes,
    labels,
    snapshots,
    tracks,
)
from pointbrush.labels.state import SequenceState

ROWS = 500
"""Rows written at once."""


def repair(connection: Connection, state: SequenceState) -> tuple[list[str], list[str]]:
    """Rebuild what of a sequence disagrees with its journal, in the caller's transaction.

    Returns what was wrong and is rebuilt, and what cannot be.  If the journal itself is damaged
    nothing is rebuilt: what was derived from it before may be all that is left.
    """
    found = check.check(connection, state)
    lost = [finding.text for finding in found if not finding.derived]
    derived = [finding.text for finding in found if finding.derived]
    if lost or not derived:
        return [], lost + derived
    _snapshots(connection, state)
    _replace(connection, state, counts, _count_rows(connection, state))
    _replace(connection, state, labels, _label_rows(connection, state))
    _replace(connection, state, tracks, _track_rows(connection, state))
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
    """Make each block's snapshot anew, of now; one at a time is in memory."""
    table = snapshots.c
    kept = select(table.frame, table.layer, table.block).where(table.sequence == state.number)
    for place in sorted(tuple(row) for row in connection.execute(kept).all()):
        frame, layer, block = place
        here = check.at(table, state.number, place)
        states = _replayed(connection, state, place)
        connection.execute(delete(snapshots).where(here))
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
    query = select(table.data).where(check.at(table, state.number, place)).order_by(table.revision)
    for data in connection.execute(query).scalars():
        change = decode_change(data)
        states[change.indices] = change.after
    return states


def _count_rows(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    tally = check.Tally(connection, state)
    list(tally.findings())
    return [
        {"frame": frame, "label": label, "points": points, "painted": painted, "held": held}
        for (frame, label), (points, painted, held) in tally.counts.items()
    ]


def _label_rows(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    here = edit_labels.c.sequence == state.number
    known = connection.execute(select(edit_labels.c.label).where(here).distinct()).scalars().all()
    folded = palette.fold(connection, state.number, known)
    return [
        {"id": label.id, **{name: getattr(label, name) for name in FIELDS}}
        for label in folded.values()
        if label is not None
    ]


def _track_rows(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    return [
        {"frame": frame, "label": label, "data": data}
        for (frame, label), data in check.expected_tracks(connection, state).items()
    ]


def _frame_rows(connection: Connection, state: SequenceState) -> list[dict[str, Any]]:
    changed = check.expected_frame_changes(connection, state)
    return [{"frame": frame, "revision": revision} for frame, revision in changed.items()]
