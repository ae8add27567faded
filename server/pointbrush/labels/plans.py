"""Drafts of the store's calls: functions from a Draft to its journal Entry."""

from __future__ import annotations

import json
import uuid
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from sqlalchemy import Connection

from pointbrush.database import schema
from pointbrush.database.statements import driver_of
from pointbrush.errors import BadInputError, ConflictError
from pointbrush.geometry.oriented_box import OrientedBox
from pointbrush.labels import journal, undo
from pointbrush.labels.boxes import journal as box_journal
from pointbrush.labels.classes import palette
from pointbrush.labels.classes.palette import Palette, free_name_and_color
from pointbrush.labels.classes.selection import allowed, require_allowed
from pointbrush.labels.draft import Draft
from pointbrush.labels.journal import Entry, Summary
from pointbrush.labels.state import SequenceState
from pointbrush.labels.types import Label, Write
from pointbrush.labels.writes import locked_error

ID_LIMIT = 128
AUTHOR_LIMIT = 256
SUMMARY_LIMIT = 500

Plan = Callable[[Draft], Entry]
Tracks = dict[tuple[int, int], str | None]


def new_entry(edit_id: str | None, author: str, kind: str, summary: Summary) -> Entry:
    """Return an entry with checked texts, and a new id if none is given.  Raises BadInputError."""
    edit_id = str(uuid.uuid4()) if edit_id is None else check_text("edit id", edit_id, ID_LIMIT)
    check_text("author", author, AUTHOR_LIMIT)
    check_text("kind", kind, 32)
    return Entry(edit_id, author, kind, summary)


def check_text(name: str, value: Any, limit: int) -> str:
    """Return ``value`` if it is text of 1 to ``limit`` characters; raises BadInputError."""
    if not isinstance(value, str):
        raise BadInputError(f"{name}: expected text, got {type(value).__name__}")
    if not 1 <= len(value) <= limit or "\0" in value:
        raise BadInputError(f"{name}: expected 1 to {limit} characters, got {value[:80]!r}")
    return value


# ── palette ──────────────────────────────────────────────────────────────────────────────────


def create(entry: Entry, label_id: int | None, fields: dict[str, Any], distinct: bool) -> Plan:
    """Add a label with checked ``fields``.  Raises ConflictError if the id is taken.

    ``distinct``: a name or colour that another label has is replaced by a free one.
    """

    def plan(draft: Draft) -> Entry:
        number = _next_id(draft) if label_id is None else label_id
        if number in draft.palette:
            raise ConflictError(f"label id: expected an unused id, {number} is taken")
        attributes = {"color": palette.default_color(number), **fields}
        if distinct:
            attributes |= free_name_and_color(attributes, draft.palette.values())
        _require_category(draft, attributes)
        label = Label(number, **attributes)
        add_label(draft, label)
        return replace(entry, summary=f"create label '{label.name}'", label=label)

    return plan


def change(entry: Entry, label_id: int, fields: dict[str, Any]) -> Plan:
    """Change fields of a label."""

    def plan(draft: Draft) -> Entry:
        label = palette.require(draft.palette, label_id)
        news = {name: value for name, value in fields.items() if getattr(label, name) != value}
        changed = replace(label, **news)
        if news:
            _require_category(draft, news)
            draft.labels[label_id] = changed
            draft.label_fields[label_id] = news
        what = ", ".join(news) or "nothing"
        return replace(entry, summary=f"change {what} of label '{label.name}'", label=changed)

    return plan


def arrange(entry: Entry, order: Sequence[int]) -> Plan:
    """Reorder labels; the others follow in their current order.

    Raises BadInputError for a repeated id, NotFoundError.
    """
    if len(set(order)) < len(order):
        raise BadInputError("order: expected each label once, got one of them twice")

    def plan(draft: Draft) -> Entry:
        for label_id in order:
            palette.require(draft.palette, label_id)
        named = set(order)
        rest = [one.id for one in palette.in_order(draft.palette.values()) if one.id not in named]
        for position, label_id in enumerate([*order, *rest]):
            label = draft.palette[label_id]
            if label.position != position:
                draft.labels[label_id] = replace(label, position=position)
                draft.label_fields[label_id] = {"position": position}
        return entry

    return plan


def remove(entry: Entry, label_id: int) -> Plan:
    """Delete a label and clear its points."""

    def plan(draft: Draft) -> Entry:
        label = palette.require(draft.palette, label_id)
        if label.locked:
            raise locked_error(draft.palette, label_id)
        draft.clear_label(label_id)
        box_journal.remove_of(draft, {label_id})
        draft.labels[label_id] = None
        draft.label_fields[label_id] = {"exists": False}
        return replace(entry, summary=f"delete label '{label.name}'")

    return plan


def merge(entry: Entry, label_id: int, others: Sequence[int]) -> Plan:
    """Move the points of ``others`` to a label, and delete the others.

    Raises BadInputError if ``others`` has a repeated id or the label itself.
    """
    if not others or label_id in others or len(set(others)) < len(others):
        raise BadInputError(
            f"labels: expected other labels than {label_id}, each once, got {list(others)[:20]}"
        )

    def plan(draft: Draft) -> Entry:
        named = [palette.require(draft.palette, one) for one in (label_id, *others)]
        for label in named:
            if label.locked:
                raise locked_error(draft.palette, label.id)
        box_journal.give(draft, set(others), label_id)
        for other in others:
            draft.give_label(other, label_id)
            draft.labels[other] = None
            draft.label_fields[other] = {"exists": False}
        names = ", ".join(f"'{label.name}'" for label in named[1:])
        return replace(entry, summary=f"merge {names} into '{named[0].name}'"[:SUMMARY_LIMIT])

    return plan


def add_label(draft: Draft, label: Label) -> None:
    """Add a label to the palette; points and boxes of an earlier label of its id are cleared."""
    draft.clear_label(label.id)
    box_journal.remove_of(draft, {label.id})
    draft.labels[label.id] = label
    draft.label_fields[label.id] = palette.fields_of(label)


def _next_id(draft: Draft) -> int:
    now = Palette(tuple(draft.palette.values()), {}, draft.state.highest_label)
    return now.free_ids().take(("", ""))


def palette_of(connection: Connection, state: SequenceState) -> Palette:
    """Return the current palette, used to choose labels to add."""
    ids = palette.given_ids(connection, state.number, state.classes)
    labels = tuple(state.palette.values())
    categories = allowed(connection, state.number, labels)
    return Palette(labels, ids, state.highest_label, categories, state.classes)


def _require_category(draft: Draft, fields: Mapping[str, Any]) -> None:
    if category := fields.get("category"):
        labels = draft.palette.values()
        require_allowed(allowed(draft.connection, draft.state.number, labels), category)


# ── points ───────────────────────────────────────────────────────────────────────────────────


Writes = Mapping[int, Write] | Iterable[tuple[int, Write]]
"""Writes by frame."""
Choose = Callable[[Palette], tuple[Sequence[Label], Writes]]
"""Returns the labels that an edit adds, with ids of ``Palette.free_ids``, and its writes."""
NewBoxes = Sequence[OrientedBox] | Callable[[], Sequence[OrientedBox]]
"""New boxes of an edit, or a function that returns them after its writes."""


def write(
    entry: Entry,
    writes: Writes | Choose,
    tracks: Tracks,
    if_match: tuple[int, int] | None,
    boxes: NewBoxes,
) -> Plan:
    """Add the chosen labels, apply the writes, set the tracks and add the boxes."""

    def plan(draft: Draft) -> Entry:
        if if_match is not None:
            _require_unchanged(draft.state, *if_match)
        frame_writes: Writes
        if callable(writes):
            labels, frame_writes = writes(palette_of(draft.connection, draft.state))
            for label in labels:
                palette.check_id(label.id)
                palette.check_fields({name: getattr(label, name) for name in palette.FIELDS})
                add_label(draft, label)
        else:
            frame_writes = writes
        for frame, what in (
            frame_writes.items() if isinstance(frame_writes, Mapping) else frame_writes
        ):
            draft.write(frame, what)
        for frame, label_id in tracks:
            draft.state.frame_points(frame)
            palette.require(draft.palette, label_id)
        draft.tracks.update(tracks)
        draft.own_tracks = True
        if callable(boxes) or boxes:
            box_journal.put(draft, boxes() if callable(boxes) else boxes)
        return entry

    return plan


def _require_unchanged(state: SequenceState, frame: int, revision: int) -> None:
    """Raise ConflictError if a frame has changed since ``revision``."""
    if revision > state.revision:
        raise ConflictError(f"revision: expected at most {state.revision}, got {revision}")
    changed = state.changed.get(frame, 0)
    if changed > revision:
        raise ConflictError(
            f"revision: frame {frame} was changed at revision {changed}, after {revision}"
        )


def check_tracks(tracks: Iterable[Mapping[str, Any]]) -> Tracks:
    """Return the tracks by frame and label, as JSON; raises BadInputError."""
    by_place: Tracks = {}
    for track in tracks:
        try:
            place = (int(track["frame"]), int(track["label"]))
            by_place[place] = json.dumps(dict(track), allow_nan=False)
        except (KeyError, TypeError, ValueError) as error:
            raise BadInputError(
                f"tracks: expected maps with frame, label and finite numbers, got {error}"
            ) from None
    return by_place


# ── undo and redo ────────────────────────────────────────────────────────────────────────────


NOTHING_TO_UNDO = "undo: expected an edit of yours, there is none"
NOTHING_TO_REDO = "redo: expected an undone edit of yours, there is none"


def take_back(entry: Entry, edit: str | None) -> Plan:
    """Undo the author's last edit in force, or the one with the id ``edit``."""
    return _turn(entry, schema.ACTIVE, undo.undo, NOTHING_TO_UNDO, edit)


def bring_back(entry: Entry, edit: str | None) -> Plan:
    """Redo the edit that the author's last undo reversed, or the one with the id ``edit``."""
    return _turn(entry, schema.UNDONE, undo.redo, NOTHING_TO_REDO, edit)


def _turn(
    entry: Entry, state: int, turn: Callable[[Draft, Any], None], none: str, named: str | None
) -> Plan:
    def plan(draft: Draft) -> Entry:
        driver, number = driver_of(draft.connection), draft.state.number
        edit = journal.top_of_stack(
            lambda statement, values: statement.ask(driver, values),
            number, entry.author, state, named,
        )  # fmt: skip
        if edit is None:
            raise ConflictError(none)
        turn(draft, edit)
        return replace(
            entry,
            summary=f"{entry.kind}: {edit.summary}",
            state=schema.INERT,
            target=edit.revision,
        )

    return plan
