"""The writer of each recording; waiting edits are committed together."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from weakref import WeakKeyDictionary

from sqlalchemy import Connection

from pointbrush.database import schema
from pointbrush.database.database import Database
from pointbrush.database.lost_answers import once_it_is_back
from pointbrush.database.revisions import LOCK, found_in
from pointbrush.database.statements import begin, commit, driver_of, together
from pointbrush.errors import NotFoundError, PointbrushError, UnavailableError
from pointbrush.labels import journal
from pointbrush.labels.blocks import SNAPSHOT_EVERY, Place
from pointbrush.labels.boxes import journal as box_journal
from pointbrush.labels.draft import Draft
from pointbrush.labels.effect import Effect, effect_of
from pointbrush.labels.journal import Entry
from pointbrush.labels.open_recordings import OpenRecordings
from pointbrush.labels.packing import States
from pointbrush.labels.state import SequenceState, cell_of
from pointbrush.labels.types import Commit
from pointbrush.labels.undo import keep_used_labels
from pointbrush.system.resources import shortage

TOGETHER = 32
"""Limit of edits in one transaction."""


@dataclass(slots=True, eq=False)
class Request:
    """An edit to commit; ``identity``: the import that it was made for.

    ``alone``: its plan writes to the database itself, so it needs a separate transaction.
    """

    edit_id: str
    plan: Callable[[Draft], Entry]
    identity: str | None
    alone: bool
    commit: Commit | None = None
    error: BaseException | None = None

    @property
    def done(self) -> bool:
        """Return whether the edit is durable or has failed."""
        return self.commit is not None or self.error is not None


class Writer:
    """Commits requests in order for each recording."""

    def __init__(self, database: Database, open_recordings: OpenRecordings) -> None:
        self._database, self._open_recordings = database, open_recordings
        self._waiting: WeakKeyDictionary[SequenceState, deque[Request]] = WeakKeyDictionary()
        self._opening = threading.Lock()

    def commit(
        self,
        sequence: str,
        edit_id: str,
        plan: Callable[[Draft], Entry],
        identity: str | None = None,
        *,
        alone: bool = True,
    ) -> Commit:
        """Commit the draft of ``plan`` as the sequence's next revision; return when it is durable.

        For an existing ``edit_id`` its commit is returned.  ``identity`` and ``alone``: see
        ``Request``.  An error of ``plan``, NotFoundError for another import, and UnavailableError
        leave the state unchanged.
        """
        state = self._open_recordings.state(sequence)
        request = Request(edit_id, plan, identity, alone)
        try:
            self._commit(state, request)
        finally:
            self._open_recordings.outbox.drain()
        if request.error is not None:
            raise request.error
        assert request.commit is not None  # noqa: S101 – done
        return request.commit

    def _commit(self, state: SequenceState, request: Request) -> None:
        """Commit a request together with other waiting requests.

        The thread with the lock commits all waiting requests: one transaction, one wait for the
        disk.
        """
        with self._opening:
            waiting = self._waiting.setdefault(state, deque())
        waiting.append(request)
        with state.lock:
            while not request.done:
                self._commit_all(state, _batch(waiting))

    def _commit_all(self, state: SequenceState, batch: list[Request]) -> None:
        """Commit a batch; an error of the database fails all its requests and changes nothing."""
        made: dict[str, Commit] = {}
        committed: list[tuple[Request, Commit]] = []
        before, written, ended = state.revision, False, False
        try:
            with self._database.write(begun=False) as connection:
                first = self._opened(connection, state, batch)
                before = state.revision
                last = False
                for request in batch:
                    known = first.get(request.edit_id) or made.get(request.edit_id)
                    if known is not None:
                        committed.append((request, replace(known, repeated=True)))
                        continue
                    draft = Draft(connection, state)
                    try:
                        require_import(state, request.identity)
                        entry = request.plan(draft)
                    except Exception as error:
                        if request.alone or isinstance(error, self._database.failures):
                            raise
                        request.error = error  # nothing is written: the other requests continue
                        continue
                    written, last = True, request is batch[-1]
                    ended = last
                    done = made[request.edit_id] = self._append(draft, entry, last=last)
                    committed.append((request, done))
                if made and not last:
                    ended = True
                    commit(driver_of(connection))
        except BaseException as error:
            if written:  # the state in memory may be partly updated and not stored
                state.revision, state.stale = before, True
            self._fail(state, batch, error, ended=ended)
            return
        for done in made.values():
            self._open_recordings.outbox.put(done)
        for request, done in committed:
            request.commit = done

    def _fail(
        self, state: SequenceState, batch: list[Request], error: BaseException, *, ended: bool
    ) -> None:
        """Set the error of uncommitted requests; ``ended``: the commit may have been sent."""
        lost = isinstance(error, UnavailableError) and not self._database.sqlite
        if ended and (lost or shortage(error) is not None):
            error = self._settle(state, batch, error)
        for request in batch:
            if request.commit is None:
                request.error = request.error or error

    def _settle(
        self, state: SequenceState, batch: list[Request], error: BaseException
    ) -> BaseException:
        """Look up the edits of a batch after an unanswered commit.

        PostgreSQL may have stored them before the connection was lost, or memory ran out after the
        commit.  Returns the error for edits that are not stored; if the database stays unreachable,
        the error says that the result is unknown.
        """

        def look() -> dict[str, Commit]:
            with self._database.write(begun=False) as connection:
                return self._opened(connection, state, batch)

        try:
            found = once_it_is_back(look)
        except UnavailableError as away:
            return UnavailableError(
                "the label database went away during the edit: the edit may be stored or not; "
                "send it again with the same id",
                private=away.private,
            )
        except PointbrushError as gone:
            return gone
        for request in batch:
            request.commit = found.get(request.edit_id)
        return error

    def _opened(
        self, connection: Connection, state: SequenceState, batch: list[Request]
    ) -> dict[str, Commit]:
        """Lock the sequence and catch up with it; return the edits that exist already."""
        driver, number = driver_of(connection), state.number
        with together(driver):
            begin(driver)
            locked = LOCK.run(driver, {"sequence_id": state.id})
            found = [journal.look_for(driver, number, request.edit_id) for request in batch]
        self._open_recordings.refresh(connection, state, found_in(LOCK.one(locked)))
        if state.number != number:
            with together(driver):
                found = [journal.look_for(driver, state.number, one.edit_id) for one in batch]
        rows = [row for row in map(journal.FIND.one, found) if row is not None]
        return {row.id: self._open_recordings.load(connection, state, row) for row in rows}

    def _append(self, draft: Draft, entry: Entry, *, last: bool) -> Commit:
        """Write an edit and apply it to memory; ``last``: also commit the transaction."""
        entry, effect = self.settled(draft, entry)
        made = self._described(draft, entry, effect)
        driver = driver_of(draft.connection)
        with together(driver):
            journal.append(driver, draft, entry, made, effect)
            self._open_recordings.watcher.announce(driver)
            if last:
                commit(driver)
        self.adopt(draft, effect)
        draft.state.turn(entry.kind, entry.target)
        return made

    def settled(self, draft: Draft, entry: Entry) -> tuple[Entry, Effect]:
        """Return the final journal entry of a draft and its visible effect."""
        effect = effect_of(draft)
        if entry.target is not None and (
            keep_used_labels(draft, effect, entry.kind) or draft.box_changes
        ):
            entry, effect = replace(entry, state=schema.KEPT), effect_of(draft)
        if entry.state == schema.ACTIVE and _is_idle(draft, entry, effect):
            draft.changes.clear()
            entry = replace(entry, state=schema.INERT)
        return entry, effect

    def _described(self, draft: Draft, entry: Entry, effect: Effect) -> Commit:
        state, palette = draft.state, draft.palette
        counts = {**state.counts_of(draft.labels), **effect.counts}
        return Commit(
            sequence=state.id,
            edit=entry.id,
            revision=draft.revision,
            author=entry.author,
            kind=entry.kind,
            summary=entry.summary_of(effect.changed, len(effect.frames)),
            changed=effect.changed,
            time=time.time(),
            target=journal.edit_id_of(draft.connection, state.number, entry.target),
            label=entry.label,
            frames=effect.frames,
            palette_changed=bool(draft.labels),
            tracks_changed=bool(draft.tracks),
            boxes=box_journal.changed_by_edit(draft),
            cells=tuple(cell_of(key, count, palette) for key, count in sorted(counts.items())),
        )

    def adopt(self, draft: Draft, effect: Effect) -> None:
        """Apply an edit to the state in memory."""
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
                self._open_recordings.upkeep.snapshot(partial(_take, state, place))


def require_import(state: SequenceState, identity: str | None) -> None:
    """Raise NotFoundError if a sequence is another import than ``identity``."""
    if identity is not None and state.identity not in (None, identity):
        raise NotFoundError(
            f"sequence: the recording that this edit was made for was deleted; {state.id!r} is "
            "another recording now"
        )


def _batch(waiting: deque[Request]) -> list[Request]:
    """Return the next requests: one that is ``alone``, or several that can share a transaction."""
    batch = [waiting.popleft()]
    while not batch[0].alone and waiting and not waiting[0].alone and len(batch) < TOGETHER:
        batch.append(waiting.popleft())
    return batch


def _is_idle(draft: Draft, entry: Entry, effect: Effect) -> bool:
    """Return whether an edit has no visible effect and writes no points of other authors."""
    if effect.changed or effect.counts or draft.labels or draft.tracks or draft.boxes:
        return False  # counts: points of a deleted label, which look unlabeled
    writers = [int(writer) for writer in draft.foreign_writers()]
    return not journal.by_others(draft.connection, draft.state.number, writers, entry.author)


def _take(state: SequenceState, place: Place) -> tuple[int, Place, int, States] | None:
    with state.lock:
        block = state.cached(place)
        if block is None or block.states is None:
            return None
        block.age, block.queued = 0, False
        return state.number, place, state.revision, block.states.copy()
