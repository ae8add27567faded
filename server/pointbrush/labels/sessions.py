"""Sequences that are open in this process: reading them, committing to them, catching up."""

from __future__ import annotations

import contextlib
import json
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from sqlalchemy import Connection, Row

from pointbrush.errors import NotFoundError, UnavailableError
from pointbrush.labels import journal, schema
from pointbrush.labels.blocks import SNAPSHOT_EVERY, BlockCache, Place
from pointbrush.labels.database import Database
from pointbrush.labels.draft import Draft
from pointbrush.labels.effect import Effect, deltas_of, effect_of, labels_in
from pointbrush.labels.journal import Entry
from pointbrush.labels.notify import Outbox, Watcher
from pointbrush.labels.packing import States
from pointbrush.labels.state import (
    SequenceState,
    cell_of,
    find_revision,
    find_sequence,
    revisions,
)
from pointbrush.labels.types import Commit
from pointbrush.labels.undo import keep_used_labels
from pointbrush.labels.upkeep import Upkeep

GAP = 2_000
"""Edits of another process beyond which everything is read anew instead."""


class Sessions:
    """The open sequences of one store.

    A state's lock is held while its sequence is read or written; the database's own lock
    (SQLite's one writer, PostgreSQL's row) is taken inside it, subscribers are called outside.
    """

    def __init__(self, database: Database, cache: BlockCache) -> None:
        self._database = database
        self._cache = cache
        self._states: dict[str, SequenceState] = {}
        self._opening = threading.RLock()
        self._listing = threading.Lock()
        self._live = self._read_live()
        # By number: another sequence of the same id has revisions of its own.
        self._seen = dict(self._live.values())
        self.came_or_went: Callable[[str], None] = lambda _: None
        """Called with the id of a sequence that another process added, deleted or replaced."""
        self.outbox = Outbox()
        self.upkeep = Upkeep(database)
        self.watcher = Watcher(database, self.catch_up)

    def close(self) -> None:
        """End the threads."""
        self.watcher.close()
        self.upkeep.close()

    # ── reading ──────────────────────────────────────────────────────────────────────────

    @contextlib.contextmanager
    def reading(self, sequence: str) -> Iterator[tuple[Connection, SequenceState]]:
        """The sequence at its newest revision; raises NotFoundError, UnavailableError."""
        state = self._state(sequence)
        try:
            with state.lock, self._database.read() as connection:
                self._refresh(connection, state)
                yield connection, state
        finally:
            self.outbox.drain()

    def rebuild(
        self,
        sequence: str,
        make: Callable[[Connection, SequenceState], tuple[list[str], list[str]]],
    ) -> tuple[list[str], list[str]]:
        """Have ``make`` write what is derived from the journal, and read everything anew."""
        state = self._state(sequence)
        with state.lock, self._database.write() as connection:
            self._refresh(connection, state, lock=True)
            state.forget_blocks()
            made = make(connection, state)
        self.forget(sequence)
        return made

    def forget(self, sequence: str) -> None:
        """Drop what is in memory of a sequence."""
        with self._opening:
            state = self._states.pop(sequence, None)
            if state is not None:
                self._seen[state.number] = state.revision
        if state is not None:
            self._cache.drop(state.number)

    def catch_up(self) -> None:
        """Take in what other processes committed, and tell the subscribers."""
        with self._listing:
            newest = self._read_live()
            before, self._live = self._live, newest
        for sequence in sorted(before.keys() | newest.keys()):
            if _number(before, sequence) != _number(newest, sequence):
                self.came_or_went(sequence)
        for sequence, (number, revision) in newest.items():
            state = self._states.get(sequence)
            if state is None:
                behind = self.outbox.wanted and revision > self._seen.get(number, 0)
            else:
                behind = (number, revision) != (state.number, state.revision)
            if behind:
                with contextlib.suppress(NotFoundError), self.reading(sequence):
                    pass

    @contextlib.contextmanager
    def listing(self) -> Iterator[None]:
        """A change of which sequences there are, made by this process, which tells of it itself."""
        with self._listing:
            yield
            with contextlib.suppress(UnavailableError):  # then it is told of a second time
                self._live = self._read_live()

    def _read_live(self) -> dict[str, tuple[int, int]]:
        with self._database.read() as connection:
            return revisions(connection)

    def _state(self, sequence: str) -> SequenceState:
        state = self._states.get(sequence)
        if state is not None:
            return state
        with self._opening:
            if sequence in self._states:
                return self._states[sequence]
            with self._database.read() as connection:
                row = find_sequence(connection, sequence)
                if row is None:
                    raise NotFoundError(
                        f"sequence: expected one that is there, {sequence!r} is not, or was deleted"
                    )
                state = SequenceState(connection, row, self._cache)
                missed = self._missed(
                    connection, state, self._seen.get(state.number, 0), state.revision
                )
            # Before anybody can commit on it, or these would come after.
            for commit in missed:
                self.outbox.put(commit)
            self._states[sequence] = state
            return state

    def _refresh(self, connection: Connection, state: SequenceState, *, lock: bool = False) -> None:
        """Bring ``state`` to the newest revision that ``connection`` sees."""
        found = find_revision(connection, state.id, lock=lock)
        if found is None:
            self.forget(state.id)
            raise NotFoundError(f"sequence: {state.id!r} was deleted")
        number, revision = found
        if number != state.number or revision < state.revision:
            # Another process made it anew, or put a backup in its place.
            row = find_sequence(connection, state.id)
            if row is not None:
                state.forget_blocks()
                state.reset(connection, row)
        elif revision > state.revision:
            self._take_in(connection, state, revision)

    def _take_in(self, connection: Connection, state: SequenceState, revision: int) -> None:
        """Catch up to ``revision``; if it fails on the way, it starts again from where it was."""
        first = state.revision
        if revision - first > GAP:
            state.forget_blocks()
        else:
            for row in journal.rows_since(connection, state.number, first, GAP):
                state.adopt(journal.changes_of(connection, state.number, row.revision))
                state.turn(row.kind, row.target)
        state.reload_palette(connection)
        state.reload_counts(connection)
        state.reload_changed(connection, first)
        missed = self._missed(connection, state, first, revision)
        state.revision = revision
        for commit in missed:
            self.outbox.put(commit)

    def _missed(
        self, connection: Connection, state: SequenceState, after: int, revision: int
    ) -> list[Commit]:
        """Commits made elsewhere; after a long absence only the last one.

        Those who listen see the gap between its base and what they have.
        """
        if not self.outbox.wanted:
            return []
        first = after if revision - after <= GAP else revision - 1
        rows = journal.rows_since(connection, state.number, first, GAP)
        return [self.load(connection, state, row) for row in rows]

    # ── writing ──────────────────────────────────────────────────────────────────────────

    def commit(
        self,
        sequence: str,
        edit_id: str,
        plan: Callable[[Draft], Entry],
        identity: str | None = None,
    ) -> Commit:
        """Make what ``plan`` drafts the sequence's next revision, durable when this returns.

        An ``edit_id`` that is there already gives its commit again.  ``identity``: of the import
        that the edit was made for.  Any error of ``plan``, NotFoundError for another import, and
        UnavailableError, leave everything as it was.
        """
        state = self._state(sequence)
        try:
            with state.lock:
                with self._database.write() as connection:
                    self._refresh(connection, state, lock=True)
                    require_import(state, identity)
                    first = self.find(connection, state, edit_id)
                    if first is not None:
                        return first
                    draft = Draft(connection, state)
                    entry = plan(draft)
                    commit, effect = self._append(draft, entry)
                # Committed: only now may memory change.
                self._adopt(draft, effect)
                state.turn(entry.kind, entry.target)
                self.outbox.put(commit)
        finally:
            self.outbox.drain()
        return commit

    def _append(self, draft: Draft, entry: Entry) -> tuple[Commit, Effect]:
        connection, state = draft.connection, draft.state
        effect = effect_of(draft)
        if entry.kind == "undo" and keep_used_labels(draft, effect):
            entry, effect = replace(entry, state=schema.KEPT), effect_of(draft)
        if entry.state == schema.ACTIVE and self._is_idle(draft, entry, effect):
            draft.changes.clear()
            entry = replace(entry, state=schema.INERT)
        if entry.state == schema.ACTIVE:
            journal.drop_redo(connection, state.number, entry.author)
        time = journal.append(self._database, draft, entry, effect)
        self.watcher.announce(connection)
        palette = draft.palette
        counts = {**state.counts_of(draft.labels), **effect.counts}
        commit = Commit(
            sequence=state.id,
            edit_id=entry.id,
            revision=draft.revision,
            author=entry.author,
            kind=entry.kind,
            summary=entry.summary,
            changed=effect.changed,
            time=time,
            target=journal.edit_id_of(connection, state.number, entry.target),
            frames=effect.frames,
            palette_changed=bool(draft.labels),
            tracks_changed=bool(draft.tracks),
            cells=tuple(cell_of(key, count, palette) for key, count in sorted(counts.items())),
        )
        return commit, effect

    def _is_idle(self, draft: Draft, entry: Entry, effect: Effect) -> bool:
        """Nothing to see, and nothing of others' that it would hold on to."""
        if effect.changed or effect.counts or draft.labels or draft.tracks:
            return False  # counts: of a deleted label, whose points look unlabeled
        writers = [int(writer) for writer in draft.foreign_writers()]
        number = draft.state.number
        return not journal.by_others(draft.connection, number, writers, entry.author)

    def _adopt(self, draft: Draft, effect: Effect) -> None:
        state = draft.state
        state.revision = draft.revision
        state.counts.update(effect.counts)
        state.changed.update(dict.fromkeys(effect.frames, state.revision))
        if draft.labels:
            state.set_palette(draft.palette.values())
        state.adopt(draft.changes)
        for place in draft.changes:
            block = state.cached(place)
            if block is not None and block.age >= SNAPSHOT_EVERY and not block.queued:
                block.queued = True
                self.upkeep.snapshot(partial(_take, state, place))

    # ── from the journal ─────────────────────────────────────────────────────────────────

    def find(self, connection: Connection, state: SequenceState, edit_id: str) -> Commit | None:
        """The commit of an edit by its id, marked as repeated, or None."""
        row = journal.find(connection, state.number, edit_id)
        return None if row is None else replace(self.load(connection, state, row), repeated=True)

    def load(self, connection: Connection, state: SequenceState, row: Row[Any]) -> Commit:
        """A past commit, whose deltas hold the values of *now* where later edits matter."""
        labels = json.loads(row.labels)
        changes = journal.changes_of(connection, state.number, row.revision)
        turned = journal.labels_that_came_or_went(connection, row) if labels else set()
        frames = deltas_of(connection, state, changes, turned)
        cells = labels_in(changes, frames) | state.counts_of(turned).keys()
        return Commit(
            sequence=state.id,
            edit_id=row.id,
            revision=row.revision,
            author=row.author,
            kind=row.kind,
            summary=row.summary,
            changed=row.points,
            time=row.time,
            target=journal.edit_id_of(connection, state.number, row.target),
            frames=frames,
            palette_changed=bool(labels),
            tracks_changed=bool(row.tracks),
            cells=tuple(state.cell(key) for key in sorted(cells)),
        )


def _number(of: Mapping[str, tuple[int, int]], sequence: str) -> int | None:
    return of[sequence][0] if sequence in of else None


def require_import(state: SequenceState, identity: str | None) -> None:
    """Raise NotFoundError when a sequence is another import than ``identity``."""
    if identity is not None and state.identity not in (None, identity):
        raise NotFoundError(
            f"sequence: the recording that this edit was made for was deleted; {state.id!r} is "
            "another one now"
        )


def _take(state: SequenceState, place: Place) -> tuple[int, Place, int, States] | None:
    with state.lock:
        block = state.cached(place)
        if block is None or block.states is None:
            return None
        block.age, block.queued = 0, False
        return state.number, place, state.revision, block.states.copy()
