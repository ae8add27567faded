"""Sequences that are open in this process: reading them, committing to them, catching up."""

from __future__ import annotations

import contextlib
import json
import logging
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from sqlalchemy import Connection, Row

from pointbrush.errors import NotFoundError, UnavailableError
from pointbrush.labels import box_journal, journal
from pointbrush.labels.blocks import BlockCache
from pointbrush.labels.database import Database
from pointbrush.labels.effect import deltas_of, labels_in
from pointbrush.labels.notify import Outbox, Watcher
from pointbrush.labels.state import (
    LOOK,
    LOOK_FOR,
    Found,
    SequenceState,
    find_revision,
    find_sequence,
    found_in,
    revisions,
)
from pointbrush.labels.statements import driver_of
from pointbrush.labels.types import Commit
from pointbrush.labels.upkeep import Upkeep

log = logging.getLogger(__name__)

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
        self._seen = {number: revision for number, revision, _ in self._live.values()}
        self.came_or_went: Callable[[str], None] = lambda _: None
        """Called with the id of a sequence that another process added, deleted or replaced."""
        self.listed: Callable[[], None] = lambda: None
        """Called after a change of which sequences there are, by this process or another."""
        self.classes_renamed: Callable[[str], None] = lambda _: None
        """Called with the id of an open sequence after classes were renamed."""
        self.outbox = Outbox()
        self.upkeep = Upkeep(database)
        self.watcher = Watcher(database, self.catch_up)

    def close(self) -> None:
        """End the threads."""
        self.watcher.close()
        self.upkeep.close()

    # ── reading ──────────────────────────────────────────────────────────────────────────

    @contextlib.contextmanager
    def knowing(self, sequence: str, *, look: bool = True) -> Iterator[SequenceState]:
        """Yield the state in memory of the sequence at its newest revision, without a transaction.

        ``look``: ask the database whether there is a newer one; else what is known will do.
        Raises NotFoundError, UnavailableError.
        """
        state = self.state(sequence)
        try:
            with state.lock:
                if look or state.stale:
                    found = found_in(self._database.look(LOOK, {"sequence_id": state.id}))
                    if state.stale or found != state.known:
                        with self._database.read() as connection:
                            self.refresh(connection, state, find_revision(connection, state.id))
                yield state
        finally:
            self.outbox.drain()

    def look_for(self, sequence: str, edit_id: str) -> Commit | None:
        """The commit of an edit by its id, ``repeated``, or None; looks at the newest revision."""
        state = self.state(sequence)
        row = self._database.look(LOOK_FOR, {"sequence_id": state.id, "edit_id": edit_id})
        if row is not None and row.edit is None:
            with state.lock:
                # What this process has committed since is in memory.
                newest = state.number == row.number and state.revision >= row.revision
                if newest and not state.stale:
                    return None
        with self.reading(sequence) as (connection, state):
            return self.find(connection, state, edit_id)

    @contextlib.contextmanager
    def reading(self, sequence: str) -> Iterator[tuple[Connection, SequenceState]]:
        """The sequence at its newest revision; raises NotFoundError, UnavailableError."""
        state = self.state(sequence)
        try:
            with state.lock, self._database.read() as connection:
                self.refresh(connection, state, find_revision(connection, state.id))
                yield connection, state
        finally:
            self.outbox.drain()

    def rebuild(
        self,
        sequence: str,
        make: Callable[[Connection, SequenceState], tuple[list[str], list[str]]],
    ) -> tuple[list[str], list[str]]:
        """Have ``make`` write what is derived from the journal, and read everything anew."""
        state = self.state(sequence)
        with state.lock, self._database.write() as connection:
            self.refresh(connection, state, find_revision(connection, state.id, lock=True))
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
        """Take in what other processes committed, and tell the subscribers.

        Raises UnavailableError; then it is to be called again.
        """
        with self._listing:
            newest = self._read_live()
            before, self._live = self._live, newest
        try:
            for sequence in sorted(before.keys() | newest.keys()):
                if _number(before, sequence) != _number(newest, sequence):
                    self.listed()
                    self.came_or_went(sequence)
        except UnavailableError:
            with self._listing:
                self._live = before
            raise
        for sequence, found in newest.items():
            number, revision, _ = found
            state = self._states.get(sequence)
            if state is None:
                behind = self.outbox.wanted and revision > self._seen.get(number, 0)
            else:
                behind = found != state.known
            if behind:
                self._look_into(sequence)

    def _look_into(self, sequence: str) -> None:
        """Bring a sequence up to date; a fault of its own keeps no other from it."""
        try:
            with self.reading(sequence):
                pass
        except NotFoundError:
            return  # it was deleted meanwhile
        except UnavailableError:
            raise
        except Exception:
            log.exception("%s: commits of another process could not be read", sequence)

    @contextlib.contextmanager
    def listing(self) -> Iterator[None]:
        """A change of which sequences there are, made by this process, which tells of it itself."""
        with self._listing:
            yield
            self.listed()
            with contextlib.suppress(UnavailableError):  # then it is told of a second time
                self._live = self._read_live()

    def _read_live(self) -> dict[str, Found]:
        with self._database.read() as connection:
            return revisions(connection)

    def state(self, sequence: str) -> SequenceState:
        """The sequence's state in memory, read when it is asked for first; NotFoundError."""
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
                        f"sequence: expected a known id, {sequence!r} does not exist or was deleted"
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

    def refresh(self, connection: Connection, state: SequenceState, found: Found | None) -> None:
        """Bring ``state`` to the numbers that ``connection`` has ``found`` for it."""
        if found is None:
            self.forget(state.id)
            raise NotFoundError(f"sequence: {state.id!r} was deleted")
        number, revision, classes = found
        renamed = classes != state.classes.revision
        if number != state.number or revision < state.revision or state.stale:
            # Another process made it anew, or put a backup in its place; or a commit failed here.
            row, before = find_sequence(connection, state.id), (state.number, state.revision)
            if row is not None:
                state.forget_blocks()
                state.reset(connection, row)
                if state.number == before[0] and state.revision > before[1]:
                    # The failed commit had reached the database after all.
                    for commit in self._missed(connection, state, before[1], state.revision):
                        self.outbox.put(commit)
        elif revision > state.revision:
            self._take_in(connection, state, revision)
        if renamed:
            state.reload_palette(connection)
            self.classes_renamed(state.id)

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

    # ── from the journal ─────────────────────────────────────────────────────────────────

    def find(self, connection: Connection, state: SequenceState, edit_id: str) -> Commit | None:
        """The commit of an edit by its id, marked as repeated, or None."""
        values = {"of_sequence": state.number, "edit_id": edit_id}
        row = journal.FIND.ask(driver_of(connection), values)
        return None if row is None else replace(self.load(connection, state, row), repeated=True)

    def load(self, connection: Connection, state: SequenceState, row: Row[Any]) -> Commit:
        """A past commit, whose deltas hold the values of *now* where later edits matter."""
        labels = json.loads(row.labels)
        changes = journal.changes_of(connection, state.number, row.revision)
        turned = journal.labels_that_came_or_went(connection, row) if labels else set()
        frames = deltas_of(connection, state, changes, turned)
        boxes = box_journal.changed_in(connection, row) if row.boxes else set()
        boxes |= box_journal.of_labels(connection, state.number, turned).keys()
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
            boxes=tuple(sorted(boxes)),
            cells=tuple(state.cell(key) for key in sorted(cells)),
        )


def _number(of: Mapping[str, Found], sequence: str) -> int | None:
    return of[sequence][0] if sequence in of else None
