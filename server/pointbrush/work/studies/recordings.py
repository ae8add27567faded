"""The recordings of a study, of which generated samples have their true labels."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.labels import Label, Write
from pointbrush.labels.types import IMPORTED
from pointbrush.samples import generate
from pointbrush.samples.recording import Recording as Sample
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.study import StudyTask
from pointbrush.work.imports.source_labels import edit_of
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
    """Make a sample whose labels are the ground truth."""
    end = task.frames.rpartition(":")[2]
    count = int(end or 1)
    if count > MOST_FRAMES:
        raise BadInputError(f"frames: expected at most {MOST_FRAMES} of a sample, got {count}")
    library.require_writable()
    sample = generate(task.sample, frames=count)
    guard = store.guards.reserve([task.recording], library.is_free)
    try:
        with library.store.target(task.recording).building(lambda *_: None) as folder:
            info = RecordingInfo(
                task.recording, sample.name, sample.fps, source=f"sample {task.sample}"
            )
            import_frames(sample.frames, folder, info, total=count)
        manifest = library.recording(task.recording).manifest
        store.recordings.register(task.recording, manifest.points, manifest.identity)
    finally:
        store.guards.end(guard)
    palette = [Label(number, name, color=color) for number, name, _, color in sample.labels]
    store.apply(
        task.recording,
        edit_id=edit_of(manifest),
        author="import",
        kind="import",
        writes=lambda _: (palette, _truths(library, task.recording, sample)),
        summary="true labels of the sample",
    )


def _truths(library: Library, sequence: str, sample: Sample) -> Iterator[tuple[int, Write]]:
    recording = library.recording(sequence)
    for frame in range(len(recording)):
        truth = sample.truth[frame][recording[frame].source_index]
        held = np.flatnonzero(truth)
        yield frame, Write(held, label=truth[held], provenance=IMPORTED)
