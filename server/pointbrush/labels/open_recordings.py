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

from pointbrush.database.database import Database
from pointbrush.database.notification import Watcher
from pointbrush.database.revisions import (
    LOOK,
    LOOK_FOR,
    Found,
    find_revision,
    find_sequence,
    found_in,
    revisions,
)
from pointbrush.database.statements import driver_of
from pointbrush.errors import NotFoundError, UnavailableError
from pointbrush.labels import journal
from pointbrush.labels.blocks import BlockCache
from pointbrush.labels.boxes import journal as box_journal
from pointbrush.labels.effect import deltas_of, labels_in
from pointbrush.labels.outbox import Outbox
from pointbrush.labels.state import SequenceState
from pointbrush.labels.types import Commit
from pointbrush.labels.upkeep import Upkeep

log = logging.getLogger(__name__)

GAP = 2_000
"""Number of edits of other processes above which the whole state is read again."""


class OpenRecordings:
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
        # By number, as another sequence with the same id has separate revisions.
        self._seen = {number: revision for number, revision, _ in self._live.values()}
        self.sequence_changed: Callable[[str], None] = lambda _: None
        """Called with the id of a sequence that another process added, deleted or replaced."""
        self.listed: Callable[[], None] = lambda: None
        """Called after a sequence is added or removed, by this process or another."""
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
        """Yield the sequence's state in memory at its newest revision, without a transaction.

        ``look``: query the database for a newer revision; False: use the state in memory.  Raises
        NotFoundError, UnavailableError.
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
        """Return the commit of an edit by its id, marked ``repeated``, or None."""
        state = self.state(sequence)
        row = self._database.look(LOOK_FOR, {"sequence_id": state.id, "edit_id": edit_id})
        if row is not None and row.edit is None:
            with state.lock:
                # Commits of this process since then are in memory.
                newest = state.number == row.number and state.revision >= row.revision
                if newest and not state.stale:
                    return None
        with self.reading(sequence) as (connection, state):
            return self.find(connection, state, edit_id)

    @contextlib.contextmanager
    def reading(self, sequence: str) -> Iterator[tuple[Connection, SequenceState]]:
        """Yield the sequence at its newest revision; raises NotFoundError, UnavailableError."""
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
        """Let ``make`` rebuild the derived tables, and drop the state in memory."""
        state = self.state(sequence)
        with state.lock, self._database.write() as connection:
            self.refresh(connection, state, find_revision(connection, state.id, lock=True))
            state.forget_blocks()
            made = make(connection, state)
        self.forget(sequence)
        return made

    def forget(self, sequence: str) -> None:
        """Drop the state of a sequence in memory."""
        with self._opening:
            state = self._states.pop(sequence, None)
            if state is not None:
                self._seen[state.number] = state.revision
        if state is not None:
            self._cache.forget(state.number)

    def catch_up(self) -> None:
        """Apply other processes' commits, and notify the subscribers.

        Raises UnavailableError; the caller has to retry.
        """
        with self._listing:
            newest = self._read_live()
            before, self._live = self._live, newest
        try:
            for sequence in sorted(before.keys() | newest.keys()):
                if _number(before, sequence) != _number(newest, sequence):
                    self.listed()
                    self.sequence_changed(sequence)
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
        """Update a sequence; log its errors, so that other sequences are still updated."""
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
        """Guard a change of the list of sequences by this process, and notify of it."""
        with self._listing:
            yield
            self.listed()
            with contextlib.suppress(UnavailableError):  # then a second notification follows
                self._live = self._read_live()

    def _read_live(self) -> dict[str, Found]:
        with self._database.read() as connection:
            return revisions(connection)

    def state(self, sequence: str) -> SequenceState:
        """Return the sequence's state in memory, read at first use; raises NotFoundError."""
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
            # Before new commits are possible, so that the order is kept.
            for commit in missed:
                self.outbox.put(commit)
            self._states[sequence] = state
            return state

    def refresh(self, connection: Connection, state: SequenceState, found: Found | None) -> None:
        """Update ``state`` to the number and revisions that ``connection`` has ``found``."""
        if found is None:
            self.forget(state.id)
            raise NotFoundError(f"sequence: {state.id!r} was deleted")
        number, revision, classes = found
        renamed = classes != state.classes.revision
        if number != state.number or revision < state.revision or state.stale:
            # Another process replaced it or restored a backup, or a commit failed in this process.
            row, before = find_sequence(connection, state.id), (state.number, state.revision)
            if row is not None:
                state.forget_blocks()
                state.reset(connection, row)
                if state.number == before[0] and state.revision > before[1]:
                    # The failed commit was stored.
                    for commit in self._missed(connection, state, before[1], state.revision):
                        self.outbox.put(commit)
        elif revision > state.revision:
            self._take_in(connection, state, revision)
        if renamed:
            state.reload_palette(connection)
            self.classes_renamed(state.id)

    def _take_in(self, connection: Connection, state: SequenceState, revision: int) -> None:
        """Catch up to ``revision``; an error leaves the revision as it was, for a retry."""
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
        """Return other processes' commits; above GAP only the last one.

        Subscribers notice the gap by its base revision.
        """
        if not self.outbox.wanted:
            return []
        first = after if revision - after <= GAP else revision - 1
        rows = journal.rows_since(connection, state.number, first, GAP)
        return [self.load(connection, state, row) for row in rows]

    # ── from the journal ─────────────────────────────────────────────────────────────────

    def find(self, connection: Connection, state: SequenceState, edit_id: str) -> Commit | None:
        """Return the commit of an edit by its id, marked as repeated, or None."""
        values = {"of_sequence": state.number, "edit_id": edit_id}
        row = journal.FIND.ask(driver_of(connection), values)
        return None if row is None else replace(self.load(connection, state, row), repeated=True)

    def load(self, connection: Connection, state: SequenceState, row: Row[Any]) -> Commit:
        """Return a past commit; where later edits matter, its deltas have the *current* values."""
        labels = json.loads(row.labels)
        changes = journal.changes_of(connection, state.number, row.revision)
        turned = journal.turned_labels(connection, row) if labels else set()
        frames = deltas_of(connection, state, changes, turned)
        boxes = box_journal.changed_in(connection, row) if row.boxes else set()
        boxes |= box_journal.of_labels(connection, state.number, turned).keys()
        cells = labels_in(changes, frames) | state.counts_of(turned).keys()
        return Commit(
            sequence=state.id,
            edit=row.id,
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
