"""The journal: appending edits and reading them back; only an edit's ``state`` ever changes.

Tables derived from it (palette, tracks, boxes, counts, each frame's last change) are updated with
each edit, so that reading them needs no replay.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import (
    Connection,
    Row,
    and_,
    bindparam,
    delete,
    insert,
    select,
    update,
)

from pointbrush.database import schema
from pointbrush.database.database import CHUNK
from pointbrush.database.schema import edit_blocks, edit_boxes, edit_labels, edit_tracks, edits
from pointbrush.database.statements import Driver, Statement, upsert
from pointbrush.labels.blocks import Place
from pointbrush.labels.draft import Changes, Draft
from pointbrush.labels.effect import Effect
from pointbrush.labels.packing import Change, decode_change
from pointbrush.labels.types import Commit, Label

FIND = Statement(
    select(edits).where(
        edits.c.sequence == bindparam("of_sequence"), edits.c.id == bindparam("edit_id")
    )
)
_ADVANCE = Statement(
    update(schema.sequences)
    .where(schema.sequences.c.number == bindparam("of_sequence"))
    .values(revision=bindparam("to_revision"), highest_label=bindparam("to_label"))
)
_DROP_REDO = Statement(
    update(edits)
    .where(
        edits.c.sequence == bindparam("of_sequence"),
        edits.c.author == bindparam("of_author"),
        edits.c.state == schema.UNDONE,
    )
    .values(state=schema.DROPPED)
)
"""Drop the author's undone edits: after a new edit they cannot be redone."""
_CHANGE_AT = select(edit_blocks.c.data).where(
    edit_blocks.c.sequence == bindparam("of_sequence"),
    edit_blocks.c.revision == bindparam("of_revision"),
    edit_blocks.c.frame == bindparam("frame"),
    edit_blocks.c.layer == bindparam("layer"),
    edit_blocks.c.block == bindparam("block"),
)
_ID_OF = select(edits.c.id).where(
    edits.c.sequence == bindparam("of_sequence"), edits.c.revision == bindparam("of_revision")
)
_REDONE = select(edits.c.revision).where(
    edits.c.sequence == bindparam("of_sequence"),
    edits.c.redone > bindparam("since"),
    edits.c.state.in_(schema.IN_FORCE),
)
_STACK = (
    select(edits)
    .where(
        edits.c.sequence == bindparam("of_sequence"),
        edits.c.author == bindparam("of_author"),
        edits.c.state == bindparam("in_state"),
    )
    .limit(1)
)
_FIRST = Statement(_STACK.order_by(edits.c.revision))
_LAST = Statement(_STACK.order_by(edits.c.revision.desc()))
_NAMED = Statement(_STACK.where(edits.c.id == bindparam("of_id")))
_INSERT_EDIT, _INSERT_BLOCK = Statement(insert(edits)), Statement(insert(edit_blocks))
_INSERT_LABEL, _INSERT_TRACK = Statement(insert(edit_labels)), Statement(insert(edit_tracks))
_INSERT_BOX = Statement(insert(edit_boxes))

BLOCKS_AT_ONCE = 256


Summary = str | Callable[[int, int], str]
"""A sentence of the history, or a function that makes it from the numbers of points and frames."""
_PUT_LABEL, _PUT_TRACK = upsert(schema.labels), upsert(schema.tracks)
_PUT_COUNT, _PUT_CHANGE = upsert(schema.counts), upsert(schema.frame_changes)
_PUT_BOX = upsert(schema.boxes)
_DROP_LABEL = Statement(
    delete(schema.labels).where(
        schema.labels.c.sequence == bindparam("sequence"), schema.labels.c.id == bindparam("id")
    )
)
_DROP_BOX = Statement(
    delete(schema.boxes).where(
        schema.boxes.c.sequence == bindparam("sequence"), schema.boxes.c.id == bindparam("id")
    )
)
_DROP_TRACK = Statement(
    delete(schema.tracks).where(
        schema.tracks.c.sequence == bindparam("sequence"),
        schema.tracks.c.frame == bindparam("frame"),
        schema.tracks.c.label == bindparam("label"),
    )
)
_FIELDS = ("id", "name", "category", "color", "locked", "visible", "instance", "position")


@dataclass(frozen=True, slots=True)
class Entry:
    """Entry of the journal: author and action."""

    id: str
    author: str
    kind: str
    summary: Summary
    state: int = schema.ACTIVE
    target: int | None = None
    """Revision of the edit that an undo or redo reverses."""
    label: Label | None = None
    """The label that it creates or changes, after the edit."""

    def summary_of(self, points: int, frames: int) -> str:
        """Return the sentence of the history."""
        return self.summary if isinstance(self.summary, str) else self.summary(points, frames)


def append(driver: Driver, draft: Draft, entry: Entry, commit: Commit, effect: Effect) -> None:
    """Write an edit and the tables derived from it, without reads."""
    number, revision = draft.state.number, draft.revision
    if entry.state == schema.ACTIVE:
        _DROP_REDO.run(driver, {"of_sequence": number, "of_author": entry.author})
    key = {"sequence": number, "revision": revision}
    _INSERT_EDIT.run(
        driver,
        {
            **key,
            "id": entry.id,
            "author": entry.author,
            "time": commit.time,
            "kind": entry.kind,
            "summary": commit.summary,
            "points": effect.changed,
            "frames": json.dumps(sorted(effect.frames)),
            "labels": json.dumps(sorted({*draft.labels, *draft.label_fields})),
            "tracks": bool(draft.tracks),
            "boxes": bool(draft.boxes or draft.box_changes),
            "target": entry.target,
            "state": entry.state,
            "redone": 0,
        },
    )
    _append_parts(driver, draft, key)
    derive(driver, draft, effect)
    _ADVANCE.run(
        driver,
        {
            "of_sequence": number,
            "to_revision": revision,
            "to_label": max([draft.state.highest_label, *draft.label_fields]),
        },
    )


def _append_parts(driver: Driver, draft: Draft, key: dict[str, Any]) -> None:
    places = list(draft.changes)
    for first in range(0, len(places), BLOCKS_AT_ONCE):
        _INSERT_BLOCK.run_each(
            driver,
            [
                {
                    **key,
                    "frame": place[0],
                    "layer": place[1],
                    "block": place[2],
                    "data": draft.changes.packed(place),
                }
                for place in places[first : first + BLOCKS_AT_ONCE]
            ],
        )
    _INSERT_LABEL.run_each(
        driver,
        [
            {**key, "label": label, "fields": json.dumps(draft.state.classes.stored(fields))}
            for label, fields in draft.label_fields.items()
        ],
    )
    _INSERT_BOX.run_each(
        driver,
        [
            {**key, "box": box, "data": json.dumps(change, allow_nan=False)}
            for box, change in draft.box_changes.items()
        ],
    )
    if draft.own_tracks:
        _INSERT_TRACK.run_each(
            driver,
            [
                {**key, "frame": frame, "label": label, "data": data}
                for (frame, label), data in draft.tracks.items()
            ],
        )


# ── reading ──────────────────────────────────────────────────────────────────────────────────


def look_for(driver: Driver, number: int, edit_id: str) -> Any:
    """Query the edit with this id; return a cursor for ``FIND.one``."""
    return FIND.run(driver, {"of_sequence": number, "edit_id": edit_id})


def rows_since(connection: Connection, number: int, revision: int, limit: int) -> list[Row[Any]]:
    """Return at most ``limit`` rows after ``revision``, oldest first."""
    query = select(edits).where(edits.c.sequence == number, edits.c.revision > revision)
    return list(connection.execute(query.order_by(edits.c.revision).limit(limit)))


def edit_id_of(connection: Connection, number: int, revision: int | None) -> str | None:
    """Return the id of the edit with this revision."""
    if revision is None:
        return None
    values = {"of_sequence": number, "of_revision": revision}
    return connection.execute(_ID_OF, values).scalar_one_or_none()


def changes_of(connection: Connection, number: int, revision: int) -> Changes:
    """Read the changes of points by an edit."""
    table = edit_blocks.c
    query = select(table.frame, table.layer, table.block, table.data).where(
        table.sequence == number, table.revision == revision
    )
    rows = connection.execute(query)
    return Changes({(frame, layer, block): data for frame, layer, block, data in rows})


def change_at(connection: Connection, number: int, revision: int, place: Place) -> Change | None:
    """Read the changes of one place by an edit."""
    frame, layer, block = place
    data = connection.execute(
        _CHANGE_AT,
        {
            "of_sequence": number,
            "of_revision": revision,
            "frame": frame,
            "layer": layer,
            "block": block,
        },
    ).scalar_one_or_none()
    return None if data is None else decode_change(data)


def turned_labels(connection: Connection, row: Row[Any]) -> set[int]:
    """Return the labels that an edit, or the one it undoes or redoes, created or deleted."""
    query = select(edit_labels.c.label, edit_labels.c.fields).where(
        edit_labels.c.sequence == row.sequence,
        edit_labels.c.revision.in_([row.revision, row.target or row.revision]),
    )
    return {label for label, fields in connection.execute(query) if "exists" in json.loads(fields)}


def by_others(connection: Connection, number: int, revisions: Sequence[int], author: str) -> bool:
    """Return whether another author wrote any of ``revisions``."""
    for start in range(0, len(revisions), CHUNK):
        query = select(edits.c.revision).where(
            edits.c.sequence == number,
            edits.c.revision.in_(revisions[start : start + CHUNK]),
            edits.c.author != author,
        )
        if connection.execute(query.limit(1)).first() is not None:
            return True
    return False


def redone_since(connection: Connection, number: int, since: int) -> list[int]:
    """Return the edits in force that were redone after revision ``since``, in order."""
    rows = connection.execute(_REDONE, {"of_sequence": number, "since": since})
    return sorted(row.revision for row in rows)


# ── stacks ───────────────────────────────────────────────────────────────────────────────────


Ask = Callable[[Statement, Mapping[str, Any]], Any]
"""Returns the row of a statement, or None."""


def top_of_stack(ask: Ask, number: int, author: str, state: int, edit: str | None = None) -> Any:
    """Return the next edit for ``author``'s undo (ACTIVE) or redo (UNDONE), or the ``edit``."""
    statement = _NAMED if edit else _LAST if state == schema.ACTIVE else _FIRST
    values = {"of_sequence": number, "of_author": author, "in_state": state}
    return ask(statement, values | ({"of_id": edit} if edit else {}))


def set_state(connection: Connection, number: int, revision: int, **values: int) -> None:
    """Mark an edit as undone, or as redone."""
    is_edit = and_(edits.c.sequence == number, edits.c.revision == revision)
    connection.execute(update(edits).where(is_edit).values(**values))


def derive(driver: Driver, draft: Draft, effect: Effect) -> None:
    """Update the palette, tracks, boxes, counts and last changes of frames."""
    key = {"sequence": draft.state.number}

    def row(**columns: Any) -> dict[str, Any]:
        return {**key, **columns}

    given = [label for label in draft.labels.values() if label is not None]
    fields = ({name: getattr(one, name) for name in _FIELDS} for one in given)
    _PUT_LABEL.run_each(driver, [row(**draft.state.classes.stored(each)) for each in fields])
    gone = [row(id=number) for number, label in draft.labels.items() if label is None]
    _DROP_LABEL.run_each(driver, gone)
    tracks = [row(frame=f, label=n, data=data) for (f, n), data in draft.tracks.items()]
    _PUT_TRACK.run_each(driver, [one for one in tracks if one["data"] is not None])
    _DROP_TRACK.run_each(driver, [one for one in tracks if one["data"] is None])
    boxes = draft.boxes.items()
    _PUT_BOX.run_each(
        driver,
        [
            row(id=n, label=fields["label"], data=json.dumps(fields, allow_nan=False))
            for n, fields in boxes
            if fields is not None
        ],
    )
    _DROP_BOX.run_each(driver, [row(id=n) for n, fields in boxes if fields is None])
    counts = effect.counts.items()
    _PUT_COUNT.run_each(
        driver,
        [row(frame=f, label=n, points=a, painted=b, held=c) for (f, n), (a, b, c) in counts],
    )
    _PUT_CHANGE.run_each(
        driver, [row(frame=frame, revision=draft.revision) for frame in effect.frames]
    )
