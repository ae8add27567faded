"""Boxes in an edit and in the journal: changes by an edit, and boxes folded from edits.

The journal has the change of each box by each edit; a box is the fold of the edits in force.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable
from typing import Any

from sqlalchemy import Connection, Row, Select, and_, func, select

from pointbrush.database.database import CHUNK
from pointbrush.database.schema import IN_FORCE, boxes, edit_boxes, edits
from pointbrush.errors import ConflictError
from pointbrush.geometry.oriented_box import OrientedBox
from pointbrush.labels.boxes.maps import Fields, box_of, changed_by, difference, fields_of
from pointbrush.labels.classes import palette
from pointbrush.labels.draft import Draft
from pointbrush.labels.types import Label
from pointbrush.labels.writes import locked_error

MOST_BOXES = 20_000
"""Of a recording."""


# ── reading ──────────────────────────────────────────────────────────────────────────────────


def stored(
    connection: Connection,
    number: int,
    *,
    ids: Collection[int] | None = None,
    labels: Collection[int] | None = None,
) -> dict[int, Fields]:
    """Read the fields of boxes by id, including boxes of deleted labels; None: all boxes."""
    query = select(boxes.c.id, boxes.c.data).where(boxes.c.sequence == number).order_by(boxes.c.id)
    if labels is not None:
        query = query.where(boxes.c.label.in_(sorted(labels)))
    if ids is None:
        return {number: json.loads(data) for number, data in connection.execute(query)}
    wanted, found = sorted(ids), {}
    for first in range(0, len(wanted), CHUNK):
        part = query.where(boxes.c.id.in_(wanted[first : first + CHUNK]))
        found.update({number: json.loads(data) for number, data in connection.execute(part)})
    return found


def of_labels(connection: Connection, number: int, labels: Collection[int]) -> dict[int, int]:
    """Return the boxes of some labels, as a map from box id to label."""
    if not labels:
        return {}
    query = select(boxes.c.id, boxes.c.label).where(boxes.c.sequence == number)
    return {box: label for box, label in connection.execute(query) if label in labels}


def _changes(number: int) -> Select[tuple[int, str]]:
    """Select the changes of a recording's boxes with their edits, the oldest first."""
    of_edit = and_(
        edits.c.sequence == edit_boxes.c.sequence, edits.c.revision == edit_boxes.c.revision
    )
    return (
        select(edit_boxes.c.box, edit_boxes.c.data)
        .join(edits, of_edit)
        .where(edits.c.sequence == number)
        .order_by(edit_boxes.c.revision)
    )


def fold(
    connection: Connection,
    number: int,
    ids: Collection[int] | None = None,
    last: int | None = None,
) -> dict[int, Fields | None]:
    """Fold the changes of boxes by the edits in force; None: the box does not exist.

    ``last``: the last edit to fold, which counts even if it is not in force.
    """
    query = _changes(number)
    if last is None:
        query = query.where(edits.c.state.in_(IN_FORCE))
    else:
        counts = edits.c.state.in_(IN_FORCE) | (edits.c.revision == last)
        query = query.where(counts, edits.c.revision <= last)
    found: dict[int, Fields] = {} if ids is None else {box: {} for box in ids}
    wanted = None if ids is None else sorted(ids)
    for first in range(0, 1 if wanted is None else len(wanted), CHUNK):
        part = query
        if wanted is not None:
            part = query.where(edit_boxes.c.box.in_(wanted[first : first + CHUNK]))
        for row in connection.execute(part):
            found[row.box] = changed_by(found.get(row.box, {}), json.loads(row.data))
    return {box: _whole(fields) for box, fields in found.items()}


def as_at(
    connection: Connection, number: int, revision: int, undone: Collection[int]
) -> dict[int, Fields]:
    """Fold the changes of boxes up to a revision, except edits ``undone`` by then."""
    query = (
        select(edit_boxes.c.box, edit_boxes.c.revision, edit_boxes.c.data)
        .where(edit_boxes.c.sequence == number, edit_boxes.c.revision <= revision)
        .order_by(edit_boxes.c.revision)
    )
    found: dict[int, Fields] = {}
    for box, changed, data in connection.execute(query):
        if changed not in undone:
            found[box] = changed_by(found.get(box, {}), json.loads(data))
    whole = {box: _whole(fields) for box, fields in found.items()}
    return {box: fields for box, fields in sorted(whole.items()) if fields is not None}


def _whole(fields: Fields) -> Fields | None:
    """Return the ordered fields of a box, or None if it does not exist."""
    if not fields.pop("exists", False) or "size" not in fields:
        return None
    poses = fields["poses"]
    return {
        "label": fields["label"],
        "size": fields["size"],
        "poses": {frame: poses[frame] for frame in sorted(poses, key=int)},
        "attributes": fields["attributes"],
        "provenance": fields["provenance"],
        "heading_known": fields["heading_known"],
    }


def changed_in(connection: Connection, row: Row[Any]) -> set[int]:
    """Return the boxes changed by an edit, or by the edit that it undoes or redoes."""
    query = select(edit_boxes.c.box).where(
        edit_boxes.c.sequence == row.sequence,
        edit_boxes.c.revision.in_([row.revision, row.target or row.revision]),
    )
    return set(connection.execute(query).scalars())


# ── an edit ──────────────────────────────────────────────────────────────────────────────────


def put(draft: Draft, news: Iterable[OrientedBox], removed: Iterable[int] = ()) -> list[int]:
    """Set boxes (id 0: a new box) and remove others; return the ids of the boxes that were set.

    Raises NotFoundError for an unknown frame or label, ConflictError for too many boxes,
    LockedLabelError.
    """
    after: dict[int, Fields | None] = dict.fromkeys(removed)
    given = list(news)
    new = sum(box.id == 0 for box in given)
    free = _first_free(draft, new) if new else 0
    for box in given:
        for frame in box.poses:
            draft.state.frame_points(frame)
        palette.require(draft.palette, box.label)
        number = box.id or free
        free += not box.id
        after[number] = fields_of(box_of(number, fields_of(box)))  # checked, of length 1
    _set(draft, after)
    return [number for number, fields in after.items() if fields is not None]


def _set(draft: Draft, after: dict[int, Fields | None]) -> None:
    """Set whole boxes, and record the change of each for the journal."""
    before = stored(draft.connection, draft.state.number, ids=after)
    for number, fields in after.items():
        old = before.get(number)
        require_unlocked(draft.palette, old, fields)
        change = difference(old, fields)
        if change:
            draft.boxes[number], draft.box_changes[number] = fields, change
        else:
            draft.boxes.pop(number, None)
            draft.box_changes.pop(number, None)


def _first_free(draft: Draft, more: int) -> int:
    """Return an id that no box ever had; raises ConflictError if ``more`` boxes are too many."""
    connection, number = draft.connection, draft.state.number
    count = select(func.count()).where(boxes.c.sequence == number)
    if connection.execute(count).scalar_one() + more > MOST_BOXES:
        raise ConflictError(f"boxes: expected at most {MOST_BOXES:,} in a recording, got more")
    highest = select(func.max(edit_boxes.c.box)).where(edit_boxes.c.sequence == number)
    return max([connection.execute(highest).scalar() or 0, *draft.boxes]) + 1


def require_unlocked(labels: dict[int, Label], *states: Fields | None) -> None:
    """Raise LockedLabelError if a state of a box has a locked label."""
    for fields in states:
        label = fields and fields["label"]
        if label in labels and labels[label].locked:
            raise locked_error(labels, label)


def remove_of(draft: Draft, labels: Collection[int]) -> None:
    """Remove the boxes of labels, including hidden boxes."""
    mine = stored(draft.connection, draft.state.number, labels=labels)
    _set(draft, dict.fromkeys(mine))


def give(draft: Draft, labels: Collection[int], to: int) -> None:
    """Move the boxes of labels to another label."""
    mine = stored(draft.connection, draft.state.number, labels=labels)
    _set(draft, {number: {**fields, "label": to} for number, fields in mine.items()})


def turn(draft: Draft, edit: Row[Any], kind: str) -> None:
    """Recompute the boxes of an undone or redone edit from the edits in force.

    If a later edit of another author changed a box, undoing its creation keeps the box.  Raises
    LockedLabelError.
    """
    if not edit.boxes:
        return
    connection, number = draft.connection, draft.state.number
    is_edit = and_(edit_boxes.c.sequence == number, edit_boxes.c.revision == edit.revision)
    ids = set(connection.execute(select(edit_boxes.c.box).where(is_edit)).scalars())
    before = stored(connection, number, ids=ids)
    for box, after in fold(connection, number, ids).items():
        old = before.get(box)
        if after == old:
            continue
        if kind == "undo" and after is None and old is not None and _by_others(draft, box, edit):
            draft.box_changes[box] = {"exists": True, **old}
            continue
        require_unlocked(draft.state.palette, old, after)
        draft.boxes[box] = after


def _by_others(draft: Draft, box: int, edit: Row[Any]) -> bool:
    """Return whether another author's edit in force has changed a box and not removed it."""
    query = _changes(draft.state.number).where(
        edit_boxes.c.box == box, edits.c.author != edit.author, edits.c.state.in_(IN_FORCE)
    )
    changes = [json.loads(row.data) for row in draft.connection.execute(query)]
    return bool(changes) and changes[-1].get("exists", True)


def labels_used(draft: Draft, among: Collection[int]) -> set[int]:
    """Return the labels of ``among`` that boxes have after an edit."""
    kept = of_labels(draft.connection, draft.state.number, among)
    used = {label for box, label in kept.items() if box not in draft.boxes}
    return used | {fields["label"] for fields in draft.boxes.values() if fields is not None}


def changed_by_edit(draft: Draft) -> tuple[int, ...]:
    """Return the boxes that an edit changes, and the boxes of labels it creates or deletes."""
    exists = draft.state.exists
    turned = {n for n, label in draft.labels.items() if (label is not None) != exists[n]}
    mine = of_labels(draft.connection, draft.state.number, turned)
    return tuple(sorted({*draft.boxes, *mine}))


def read_boxes(found: dict[int, Fields], palette: Collection[int]) -> list[OrientedBox]:
    """Build boxes from fields, except boxes of labels that are not in the palette."""
    return [box_of(n, fields) for n, fields in found.items() if fields["label"] in palette]
