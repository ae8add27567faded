"""All recordings of a workspace, their faults, and repairs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial

from pointbrush import sequences
from pointbrush.database.project_tables import FIRST
from pointbrush.errors import (
    DamagedError,
    NotFoundError,
    ReadOnlyError,
    UnavailableError,
)
from pointbrush.names import SCRATCH
from pointbrush.sequences import note_checksums, verify
from pointbrush.sequences.storage.checksums import CHECKSUMS
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.summaries import Search
from pointbrush.values.recordings import Manifest
from pointbrush.work.deletion import Deletion
from pointbrush.work.imports.submitting import Imports
from pointbrush.work.library import LABELS_ALONE, Library
from pointbrush.work.manifests import NOTHING, listed

LABELS_MISSING = "labels were not imported"
"""Prefix of the message about a recording without the labels in its files."""


@dataclass(slots=True)
class Repaired:
    """Repaired and irreparable faults, one sentence each."""

    rebuilt: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)


def _repair_database(store: WorkspaceStore, done: Repaired) -> None:
    faults = store.integrity()
    if not faults:
        return
    try:
        store.rebuild_indexes()
    except ReadOnlyError:
        raise
    except UnavailableError as error:
        faults = [*faults, f"database: its indexes cannot be made anew: {error}"]
    else:
        left = store.integrity()
        done.rebuilt += [line for line in faults if line not in left]
        faults = left
    done.lost += [f"{line}; restore it from a backup" for line in faults]


def _repair_labels(store: WorkspaceStore, sequence: str, done: Repaired) -> None:
    try:
        rebuilt, lost = store.repair(sequence)
    except ReadOnlyError:
        raise
    except Exception as error:  # damaged rows have values of any type
        rebuilt, lost = [], [f"its labels cannot be read: {error}"]
    done.rebuilt += [f"{sequence}: {line}" for line in rebuilt]
    done.lost += [
        f"{sequence}: {line}; nothing of its labels was changed, restore them from a backup"
        for line in lost
    ]


class Listing:
    """The recordings of a workspace, their faults, and repairs; thread-safe."""

    def __init__(
        self, library: Library, store: WorkspaceStore, imports: Imports, deletion: Deletion
    ) -> None:
        self._library, self._store = library, store
        self._imports, self._deletion = imports, deletion

    def all(self, *, copies: bool = False) -> list[Manifest]:
        """Return all recordings with files or labels, by name, except unfinished imports.

        ``copies``: include copies for one person.  The scratch recording is excluded.
        """
        folders, revisions = self._library.survey(), self._store.sequences()
        if revisions.keys() != {folder.id for folder in folders}:
            # A deletion or an import was interrupted, on this or another server.
            self._deletion.tidy()
            for one in folders:
                if one.id not in revisions:
                    self._library.store.forget(one.id)
            folders = self._library.survey()
            self._imports.complete([one.manifest for one in folders if one.manifest is not None])
            revisions = self._store.sequences()
        of_copies = self._store.team.copies.originals()
        if not copies:
            folders = [one for one in folders if one.id not in of_copies]
            revisions = {n: number for n, number in revisions.items() if n not in of_copies}
        whole = revisions.keys() == {one.id for one in folders}
        importing = () if whole else self._store.guards.importing()
        progress, projects = self._store.progress(), self._store.team.summaries.projects()
        missing = self._imports.source_labels.missing(
            one.manifest for one in folders if one.manifest
        )
        entries = [
            listed(
                one.id,
                revisions.get(one.id, 0),
                one.manifest,
                one.damaged,
                progress.get(one.id, NOTHING),
                labels_missing=missing.get(one.id),
                project=projects.get(one.id, FIRST),
                copy_of=of_copies.get(one.id),
            )
            for one in folders
            if one.id != SCRATCH and (one.id in revisions or one.id not in importing)
        ]
        alone = revisions.keys() - {one.id for one in folders} - {SCRATCH}
        entries += [listed(name, revisions[name], None, LABELS_ALONE) for name in alone]
        return sorted(entries, key=lambda entry: (entry.name.lower(), entry.id))

    def search(self, search: Search, text: str = "") -> list[Manifest]:
        """Return recordings by conditions on their labels, and by a part of their name or id.

        Copies for one person are included.
        """
        wanted = text.strip().lower()
        manifests: dict[str, sequences.Manifest] = {}
        matches = self._store.team.summaries.matching(search)
        matches.pop(SCRATCH, None)
        for sequence in matches:
            with suppress(NotFoundError, DamagedError):
                manifest = self._library.recording(sequence).manifest
                if wanted in sequence or wanted in manifest.name.lower():
                    manifests[sequence] = manifest
        progress = self._store.progress(manifests)
        entries = [
            listed(
                sequence,
                matches[sequence].revision,
                manifest,
                progress=progress.get(sequence, NOTHING),
                project=matches[sequence].project,
                copy_of=matches[sequence].copy_of,
            )
            for sequence, manifest in manifests.items()
        ]
        return sorted(entries, key=lambda entry: (entry.name.lower(), entry.id))

    def entry(self, sequence: str) -> Manifest:
        """Return one recording; raises NotFoundError if it has neither files nor labels."""
        revision = self._store.sequences().get(sequence)
        if self._library.has(sequence):
            folder = self._library.look(sequence)
            progress = self._store.progress([sequence]).get(sequence, NOTHING)
            return listed(
                sequence,
                revision or 0,
                folder.manifest,
                folder.damaged,
                progress,
                labels_missing=self._labels_missing(folder.manifest),
                project=self._store.team.summaries.project(sequence),
            )
        if revision is None:
            raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
        return listed(sequence, revision, None, LABELS_ALONE)

    def _labels_missing(self, manifest: sequences.Manifest | None) -> str | None:
        if manifest is None:
            return None
        return self._imports.source_labels.missing([manifest]).get(manifest.id)

    def problems(self, sequence: str) -> list[str]:
        """Return the faults of a recording's files, journal and annotations.

        Raises NotFoundError if it has neither files nor labels, UnavailableError.
        """
        known, files = sequence in self._store.sequences(), self._library.has(sequence)
        if not known and not files:
            raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
        if not files:
            return [LABELS_ALONE, *_problems(lambda: self._store.check(sequence))]
        look = self._library.look(sequence)
        missing = self._labels_missing(look.manifest)
        damaged = look.damaged or (f"its {LABELS_MISSING}: {missing}" if missing else None)
        problems = _problems(lambda: verify(self._library.store.files(sequence)))
        if known:
            problems += _problems(lambda: self._store.check(sequence), "its labels")
        return problems if damaged is None else [damaged, *problems]

    def repair(self, recordings: Iterable[str]) -> Repaired:
        """Repair recordings as far as possible; no other process may have the workspace open.

        Indexes are rebuilt from the database's rows; snapshots, counts, palette and tracks from the
        journal.  Files of frames, the journal and manifests cannot be repaired.  Raises
        ReadOnlyError.
        """
        done = Repaired()
        _repair_database(self._store, done)
        if done.lost:
            return done
        for sequence in recordings:
            _repair_labels(self._store, sequence, done)
            if not self._library.has(sequence):
                done.lost.append(f"{sequence}: {LABELS_ALONE}")
                continue
            done.lost += [
                f"{sequence}: {line}; import it again or restore it from a backup"
                for line in _problems(partial(self._repair_files, sequence, done))
            ]
        return done

    def _repair_files(self, sequence: str, done: Repaired) -> list[str]:
        """Add missing checksums of a recording, and return the faults of its files."""
        files = self._library.store.files(sequence)
        if note_checksums(files):
            done.rebuilt.append(
                f"{sequence}: it had no checksums; {CHECKSUMS} now has those of its present files"
            )
        return verify(files)


def _problems(look: Callable[[], list[str]], part: str = "") -> list[str]:
    """Return the findings of ``look``; an error in it is a finding too, as damage can cause any.

    Raises ReadOnlyError, and UnavailableError without a ``part``.
    """
    try:
        return look()
    except ReadOnlyError:
        raise
    except Exception as error:
        if isinstance(error, UnavailableError) and not part:
            raise
        return [f"{part} cannot be read: {error}" if part else f"cannot be checked: {error}"]
