"""Undo and redo: a point shows the value written by the last edit in force.

Undo of edit E disables it; redo enables it again at its *original position* in the order.  The
state therefore always equals a replay of the journal without the undone edits.  An undo changes
only points with the writer E; a redo changes only points without a later writer.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, Row, and_, select

from pointbrush.database import schema
from pointbrush.database.schema import IN_FORCE, edit_tracks, edits
from pointbrush.errors import UnavailableError
from pointbrush.labels import journal
from pointbrush.labels.blocks import Place
from pointbrush.labels.boxes import journal as box_journal
from pointbrush.labels.classes.palette import as_last_made, fields_of, fold
from pointbrush.labels.draft import Draft, match_sorted
from pointbrush.labels.effect import Effect
from pointbrush.labels.packing import LABEL_BITS, LABELS, States, writer_of
from pointbrush.labels.state import visible
from pointbrush.labels.writes import locked_error

Indices = NDArray[np.int64]
_Redone = dict[int, list[int]]


@dataclass(slots=True, eq=False)
class _Uncovered:
    """Points of one place that lose their last edit; ``words`` becomes the value below it.

    ``link``: the oldest edit of the chain so far.
    """

    place: Place
    indices: Indices
    now: States
    words: States
    link: int


def undo(draft: Draft, edit: Row[Any]) -> None:
    """Fill ``draft`` with the state without ``edit``, and mark the edit undone.

    Raises LockedLabelError when that would change points of a locked label.
    """
    connection, number = draft.connection, draft.state.number
    # Read before the change, as it is cached and the undo may not be committed.
    undone = draft.state.undone(connection)
    journal.set_state(connection, number, edit.revision, state=schema.UNDONE)
    redone: _Redone = {}
    for place, change in journal.changes_of(connection, number, edit.revision).items():
        now = draft.words(place, change.indices)
        mine = writer_of(now) == np.uint64(edit.revision)
        if not mine.any():
            continue
        before = change.before[mine]  # a copy
        one = _Uncovered(place, change.indices[mine], now[mine], before, edit.revision)
        while gone := undone.intersection(np.unique(writer_of(one.words)).tolist()):
            _step_down(connection, number, one, sorted(gone))
        _lay_redone_over(connection, number, one, edit.revision, redone)
        draft.put(one.place, one.indices, one.now, one.words)
    _require_unlocked(draft)
    _palette(draft, edit)
    _tracks(draft, edit)
    box_journal.turn(draft, edit, "undo")


def redo(draft: Draft, edit: Row[Any]) -> None:
    """Fill ``draft`` with the state that includes ``edit`` again, and mark it in force.

    Raises LockedLabelError when that would change points of a locked label.
    """
    connection, number = draft.connection, draft.state.number
    journal.set_state(connection, number, edit.revision, state=schema.ACTIVE, redone=draft.revision)
    for place, change in journal.changes_of(connection, number, edit.revision).items():
        now = draft.words(place, change.indices)
        older = writer_of(now) < np.uint64(edit.revision)
        draft.put(place, change.indices[older], now[older], change.after[older])
    _require_unlocked(draft)
    _palette(draft, edit)
    _tracks(draft, edit)
    box_journal.turn(draft, edit, "redo")


def _step_down(connection: Connection, number: int, one: _Uncovered, gone: list[int]) -> None:
    """Replace words of undone edits by the words that *these* edits replaced.

    The writer of such a word may itself be undone now, and so on down the chain.
    """
    writers = writer_of(one.words)
    for writer in gone:
        rows = np.flatnonzero(writers == np.uint64(writer))
        change = journal.change_at(connection, number, writer, one.place)
        if change is None:
            raise UnavailableError(
                f"undo: the record of edit {writer} is missing; run 'pointbrush check' for details"
            )
        at, mine = match_sorted(change.indices, one.indices[rows])
        one.words[rows[mine]] = change.before[at]
        one.link = min(one.link, writer)


def _lay_redone_over(
    connection: Connection, number: int, one: _Uncovered, revision: int, known: _Redone
) -> None:
    """Apply redone edits that a chain misses.

    A chain misses an edit only if it was undone when a link of the chain was made, and redone
    afterwards; these few edits are applied in the order of the journal.  ``known``: edits redone
    since a link, shared by most places.
    """
    if one.link not in known:
        known[one.link] = journal.redone_since(connection, number, one.link)
    oldest = int(writer_of(one.words).min())
    for other in known[one.link]:
        if not oldest < other < revision:
            continue
        change = journal.change_at(connection, number, other, one.place)
        if change is None:
            continue
        at, mine = match_sorted(change.indices, one.indices)
        rows = np.flatnonzero(mine)
        newer = writer_of(one.words[rows]) < np.uint64(other)
        one.words[rows[newer]] = change.after[at[newer]]


def _require_unlocked(draft: Draft) -> None:
    state = draft.state
    if not state.locked.any():
        return
    for (frame, layer, block), change in draft.changes.items():
        before, after = (visible(words, state.exists) for words in (change.before, change.after))
        differs = before != after
        if layer == LABELS:
            shown = [before, after]
        else:
            words = draft.words((frame, LABELS, block), change.indices)
            shown = [visible(words, state.exists)]
        for values in shown:
            labels = (values & LABEL_BITS).astype(np.intp)
            barred = differs & state.locked[labels]
            if barred.any():
                raise locked_error(state.palette, int(labels[barred][0]))


def _palette(draft: Draft, edit: Row[Any]) -> None:
    label_ids = json.loads(edit.labels)
    if not label_ids:
        return
    state, now = draft.state, draft.state.palette
    for label_id, label in fold(draft.connection, state.number, label_ids, state.classes).items():
        if label is None:
            draft.doubtful.add(label_id)
        if label != now.get(label_id):
            draft.labels[label_id] = label


def keep_used_labels(draft: Draft, effect: Effect, kind: str) -> bool:
    """Keep labels that points or boxes hold; return whether any label was kept.

    Undoing the creation of a label must not remove other people's work, and points that an undo or
    redo uncovers must keep their label even if its creation was undone meanwhile.
    """
    boxes = {fields["label"] for fields in draft.boxes.values() if fields is not None}
    held = {label for _, label in effect.counts}
    missing = (draft.doubtful | held | boxes) - draft.palette.keys()
    if not missing:
        return False
    counts = {**draft.state.counts_of(missing), **effect.counts}
    used = {label for (_, label), count in counts.items() if count[2]}
    used |= box_journal.labels_used(draft, missing)
    state = draft.state
    before = state.palette if kind == "undo" else {}
    for label_id in sorted(missing & used):
        label = before.get(label_id) or as_last_made(
            draft.connection, state.number, label_id, state.classes
        )
        if label is not None:  # None: it was deleted, which is kept
            draft.label_fields[label_id] = fields_of(label)
            draft.labels[label_id] = label
            if label == state.palette.get(label_id):
                del draft.labels[label_id]
    return bool(draft.label_fields)


def _tracks(draft: Draft, edit: Row[Any]) -> None:
    if not edit.tracks:
        return
    mine, other = edit_tracks.alias(), edit_tracks.alias()
    key = (draft.state.number, edit.revision)
    query = (
        select(other.c.frame, other.c.label, other.c.data)
        .join(
            mine,
            and_(
                mine.c.sequence == other.c.sequence,
                mine.c.frame == other.c.frame,
                mine.c.label == other.c.label,
            ),
        )
        .join(
            edits,
            and_(edits.c.sequence == other.c.sequence, edits.c.revision == other.c.revision),
        )
        .where(mine.c.sequence == key[0], mine.c.revision == key[1])
        .where(edits.c.state.in_(IN_FORCE))
        .order_by(other.c.revision)
    )
    places = select(mine.c.frame, mine.c.label).where(
        mine.c.sequence == key[0], mine.c.revision == key[1]
    )
    for frame, label in draft.connection.execute(places):
        draft.tracks[frame, label] = None
    for frame, label, data in draft.connection.execute(query):
        draft.tracks[frame, label] = data
