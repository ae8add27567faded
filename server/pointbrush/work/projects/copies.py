"""Copies of recordings, each for one person; the person sees an ordinary recording."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from pointbrush.labels import Write
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.storage.manifest import rename_sequence
from pointbrush.sequences.storage.recording_files import FolderFiles
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.teamwork.copies import CopyKind
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.imports.source_labels import edit_of, source_labels_summary
from pointbrush.work.library import Library
from pointbrush.work.trash import ids_for


def make_copy(
    store: WorkspaceStore,
    library: Library,
    sequence: str,
    project: str,
    frames: range,
    kind: CopyKind,
    labels: Collection[str] | None = None,
) -> str:
    """Copy a recording with its palette within a project; return the id of the copy.

    A copy for agreement starts with the current labels of ``frames``, other copies without labels.
    ``labels``: names of the labels in its palette; None: all.  Raises NotFoundError.
    """
    recording = library.recording(sequence)
    library.require_writable()
    known = [*store.recordings.live(), *store.recordings.deleted()]
    taken = {one.id for one in known}
    ids = ids_for(recording.manifest.name)  # as for an import of the same file
    guard = store.guards.reserve(ids, lambda id_: id_ not in taken and library.is_free(id_))
    try:
        with library.store.staging() as partial:
            _linked(library.store.files(sequence), partial)
            manifest = rename_sequence(partial, guard.sequence)
            store.recordings.register(guard.sequence, manifest.points, manifest.identity, project)
            store.team.copies.mark(guard.sequence, sequence, project, kind)
            library.store.publish(partial, guard.sequence)
    finally:
        store.guards.end(guard)
    store.team.access.forget()
    palette = [
        replace(each, locked=False)
        for each in store.palette(sequence)
        if labels is None or each.name in labels
    ]
    chosen = frames if kind == "agreement" else range(0)
    store.apply(  # like labels from files, so that the history does not reveal the copy
        guard.sequence,
        edit_id=edit_of(recording.manifest),
        author="import",
        kind="import",
        writes=lambda _: (palette, _copied(store, recording, chosen)),
        summary=lambda _, changed: source_labels_summary(changed),
    )
    return guard.sequence


def _copied(
    store: WorkspaceStore, recording: Recording, frames: range
) -> Iterator[tuple[int, Write]]:
    for frame in frames:
        values = store.values(recording.manifest.id, frame)
        held = np.flatnonzero((values.label > 0) | values.deleted)
        if len(held):
            yield (
                frame,
                Write(
                    held,
                    label=values.label[held],
                    provenance=values.provenance[held],
                    deleted=values.deleted[held],
                ),
            )


def _linked(files: RecordingFiles, target: Path) -> None:
    """Copy a recording; for a folder, by hard links, as its files never change."""

    def link(source: str, place: str) -> None:
        try:
            os.link(source, place)
        except OSError:  # a file system without links
            shutil.copy2(source, place)

    if isinstance(files, FolderFiles):
        shutil.copytree(files.path, target, copy_function=link)
    else:
        files.copy_to(target)
