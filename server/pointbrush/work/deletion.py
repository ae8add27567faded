"""Deleting and restoring recordings: a transaction in the database, then repeatable moves of files.

After an interruption a recording is intact, or deleted and restorable; ``tidy`` completes the
moves.
"""

from __future__ import annotations

import logging
import secrets
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from pointbrush.errors import NotFoundError, PointbrushError, ReadOnlyError, UnavailableError
from pointbrush.labels import Known
from pointbrush.sequences import Manifest
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.events import Event, SequencesChanged
from pointbrush.work.imports.new_recordings import register
from pointbrush.work.library import Library

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Deleted:
    """A deleted recording; ``manifest`` is None if its files are damaged or missing."""

    known: Known
    manifest: Manifest | None


class Deletion:
    """Deletes and restores the recordings of one workspace."""

    def __init__(
        self, library: Library, store: WorkspaceStore, publish: Callable[[Event], None]
    ) -> None:
        self._library, self._store, self._publish = library, store, publish
        self._trash = library.store.deleted

    def delete(self, sequence: str, identity: str | None = None) -> None:
        """Delete a recording with its labels; it can be restored for ``KEPT_SECONDS``.

        ``identity``: of the recording; a repeated call has no effect.  Raises NotFoundError,
        ConflictError while it is imported or tracked, UnavailableError.
        """
        self._library.require_writable()
        if identity is not None and self._is_deleted(identity):
            return
        if self._library.has(sequence):
            self._require(sequence, identity)
            self._register(sequence)
        self._store.recordings.delete(sequence)
        self._library.hidden |= {sequence}
        self._tidy_later()
        self._publish(SequencesChanged(sequence))

    def erase(self, sequence: str) -> Known:
        """Delete a recording with its labels for ever, and return it; raises as ``delete``."""
        self._library.require_writable()
        known = self._store.recordings.delete(sequence)
        self._library.hidden |= {sequence}
        self.tidy()
        self._trash.purge(known)
        if self._library.store.has(sequence):
            raise UnavailableError(f"sequence: the files of {sequence!r} cannot be removed now")
        self._store.recordings.erase(known.number)
        self._publish(SequencesChanged(sequence))
        return known

    def _is_deleted(self, identity: str) -> bool:
        return any(known.identity == identity for known in self._store.recordings.deleted())

    def _require(self, sequence: str, identity: str | None) -> None:
        manifest = self._library.look(sequence).manifest
        if identity is not None and manifest is not None and manifest.identity != identity:
            raise NotFoundError(
                f"identity: expected that of {sequence}, got {identity!r}: it is another recording"
            )

    def _register(self, sequence: str) -> None:
        """Ensure that a recording has a row, even if its import was interrupted."""
        if sequence in self._store.guards.importing():
            return
        manifest = self._library.look(sequence).manifest
        if manifest is not None:
            register(self._store, manifest)
        elif sequence not in self._store.sequences():
            self._store.recordings.register(sequence, [], secrets.token_hex(8))

    def deleted(self) -> list[Deleted]:
        """Return the restorable recordings, last deleted first."""
        self.tidy()
        return [
            Deleted(known, self._trash.manifest(known))
            for known in self._store.recordings.deleted()
        ]

    def restore(self, key: str) -> str:
        """Restore the last deleted recording with the id or identity ``key``; return its id.

        If its id is taken, it gets another one.  An identity of a restored recording returns its
        id.  Raises NotFoundError.
        """
        self._library.require_writable()
        self.tidy()
        for known in self._store.recordings.deleted():
            if key in (known.id, known.identity):
                break
        else:
            for live in self._store.recordings.live():
                if key == live.identity:
                    return live.id
            raise NotFoundError(f"sequence: expected a deleted recording, got {key!r}")
        guards = self._store.guards
        room = partial(self._trash.has_room, known)
        guard = guards.reserve(self._trash.ids_for(known), room)
        try:
            self._store.recordings.restore(known.number, guard.sequence)
            self._tidy_later()
        finally:
            guards.end(guard)
        self._publish(SequencesChanged(guard.sequence))
        return guard.sequence

    def _tidy_later(self) -> None:
        """Call ``tidy`` after the transaction; failed moves are repeated by a later call."""
        try:
            self.tidy()
        except UnavailableError as error:
            log.warning("folders of deleted recordings are moved later: %s", error)

    def tidy(self) -> None:
        """Move folders as the database requires, and purge expired recordings.

        Raises UnavailableError; folders that cannot be moved are hidden, and retried later.
        """
        recordings = self._store.recordings
        deleted = recordings.deleted()
        if not deleted and self._trash.is_empty():
            self._library.hidden = frozenset()
            return
        try:
            with self._trash.alone():
                self._move_all()
        except (OSError, ReadOnlyError) as error:
            log.warning("folders of deleted recordings cannot be moved now: %s", error)
            self._library.hidden = frozenset(known.id for known in self._unmoved())

    def _move_all(self) -> None:
        recordings = self._store.recordings
        stuck = [
            known
            for known in self._unmoved()
            if not self._try_move(known, self._trash.move_to_trash)
        ]
        self._library.hidden = frozenset(known.id for known in stuck)
        if not self._trash.is_empty():
            for known in filter(self._trash.is_in_trash, recordings.live()):
                self._try_move(known, self._trash.move_back)
        for known in recordings.expired():
            self._trash.purge(known)
            recordings.purge(known.number)

    def _unmoved(self) -> list[Known]:
        """Return deleted recordings with folders in their original place."""
        live = {known.id for known in self._store.recordings.live()}
        deleted = self._store.recordings.deleted()
        return [
            known for known in deleted if known.id not in live and self._trash.is_unmoved(known)
        ]

    def _try_move(self, known: Known, move: Callable[[Known], None]) -> bool:
        try:
            move(known)
        except (OSError, PointbrushError) as error:
            log.warning("the folder of %s cannot be moved now: %s", known.id, error)
            return False
        return True
