"""The recordings of a study, of which generated samples have their true labels."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.palette import SourceLabel
from pointbrush.samples import generate
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.sequences.storage.manifest import note_import
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.study import StudyTask
from pointbrush.work.imports.new_recordings import register
from pointbrush.work.imports.source_labels import import_source_labels
from pointbrush.work.library import Library
from pointbrush.work.studies.overlap import frames_of, ids_of, truth_of

MOST_FRAMES = 30
"""Frames of a generated sample, each about a second of work and 4 MB."""


def require_task(store: WorkspaceStore, library: Library, task: StudyTask) -> None:
    """Raise BadInputError, NotFoundError unless the recording, labels and truth of a task exist.

    A missing recording is generated if the task names a sample.
    """
    if task.sample and not library.has(task.recording):
        _generate(store, library, task)
    frames_of(library, task)
    true = set[int]().union(*map(np.unique, truth_of(store, library, task).values()))
    for name, label in zip(task.labels, ids_of(store, task), strict=True):
        if label not in true:
            raise BadInputError(f"truth: expected points of {name!r} in the frames of {task.name}")


def _generate(store: WorkspaceStore, library: Library, task: StudyTask) -> None:
    """Import a sample with its ground truth, as if its files had the labels."""
    count = int(task.frames.rpartition(":")[2] or 1)
    if count > MOST_FRAMES:
        raise BadInputError(f"frames: expected at most {MOST_FRAMES} of a sample, got {count}")
    library.require_writable()
    sample = generate(task.sample, frames=count)
    info = RecordingInfo(task.recording, sample.name, sample.fps, f"sample {task.sample}")
    palette = [asdict(SourceLabel(n, name, "", color)) for n, name, _, color in sample.labels]
    labelled = (replace(sample.frames[n], label=sample.truth[n]) for n in range(count))
    guard = store.guards.reserve([task.recording], library.is_free)
    try:
        with library.store.target(task.recording).building(lambda *_: None) as folder:
            import_frames(labelled, folder, info, total=count)
            note_import(folder, palette=palette)
        register(store, library.recording(task.recording).manifest)
    finally:
        store.guards.end(guard)
    import_source_labels(store, library.recording(task.recording), "import")
