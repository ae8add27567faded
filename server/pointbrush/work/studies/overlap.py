"""The ground truth of a task, and the overlap of a participant's labels with it over time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.labels.draft import Changes
from pointbrush.labels.types import EditInfo, FrameValues
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.study import StudyTask
from pointbrush.work.exporting import parse_frames
from pointbrush.work.library import Library
from pointbrush.work.studies.replaying import Replayed

Labels = NDArray[np.uint16]
Frames = Mapping[int, Labels]
"""Label of each point by frame, stored order; 0 for deleted points."""


def frames_of(library: Library, task: StudyTask) -> range:
    """Return the frames of a task; raises NotFoundError, BadInputError."""
    return parse_frames(task.frames, len(library.recording(task.recording)))


def shown(values: FrameValues) -> Labels:
    """Return the labels of points, 0 for deleted ones."""
    return np.where(values.deleted, np.uint16(0), values.label)


def ids_of(store: WorkspaceStore, task: StudyTask) -> tuple[int, ...]:
    """Return the ids of the labels to reach, in the order of the task.

    Raises BadInputError for a name that the palette lacks, such as that of a renamed label.
    """
    ids = {each.name: each.id for each in store.palette(task.recording)}
    if lacking := [name for name in task.labels if name not in ids]:
        raise BadInputError(
            f"labels: expected some of {', '.join(ids)} for {task.name}, got {lacking[0]!r}"
        )
    return tuple(ids[name] for name in task.labels)


def truth_of(store: WorkspaceStore, library: Library, task: StudyTask) -> Frames:
    """Return the ground truth of a task, with the label ids of its recording.

    Raises NotFoundError for an unknown recording or snapshot.
    """
    recording, frames = task.recording, frames_of(library, task)
    if not task.truth:
        return {frame: shown(store.values(recording, frame)) for frame in frames}
    past = store.at(store.versions.moment(task.truth, recording))
    counts = library.recording(recording).manifest.points
    return {frame: shown(past.values(recording, frame, 0, counts[frame])) for frame in frames}


class Overlap:
    """Intersection over union of labels with the ground truth, by frames."""

    def __init__(self, truth: Frames, labels: Sequence[int]) -> None:
        """``labels``: the ids to reach; labels without points in ``truth`` do not count."""
        self._truth = truth
        true = np.sum([_counts(values) for values in truth.values()], axis=0)
        self._labels = [each for each in labels if true[each]]
        self._shares = {frame: self._share(frame, np.zeros_like(truth[frame])) for frame in truth}

    @classmethod
    def of(cls, store: WorkspaceStore, library: Library, task: StudyTask) -> Overlap:
        """Return the overlap of no labels with the ground truth of a task."""
        return cls(truth_of(store, library, task), ids_of(store, task))

    @property
    def iou(self) -> float:
        """Return the mean intersection over union of the labels, over all frames together."""
        both, either = np.sum([*self._shares.values()], axis=0)
        return float(np.mean(both / either)) if self._labels else 0.0

    def put(self, frame: int, values: FrameValues) -> None:
        """Set the labels of a frame, which has no effect without ground truth of it."""
        if frame in self._truth:
            self._shares[frame] = self._share(frame, shown(values))

    def _share(self, frame: int, values: Labels) -> NDArray[np.int64]:
        """Return the points of intersection and union by label."""
        true = self._truth[frame]
        both = _counts(values[values == true])
        return np.array([both, _counts(values) + _counts(true) - both])[:, self._labels]


def _counts(values: Labels) -> NDArray[np.int64]:
    return np.bincount(values, minlength=1 << 16)


Point = tuple[float, float]
"""Seconds since the task began, and the IoU from then on."""


def curve_of(
    edits: Iterable[tuple[EditInfo, Changes]], times: Mapping[str, float], overlap: Overlap,
    replayed: Replayed,
) -> Iterator[Point]:  # fmt: skip
    """Yield the IoU at the begin and after each edit that has a time, by the edit's id."""
    yield 0.0, overlap.iou
    for edit, changes in edits:
        for frame in replayed.apply(changes):
            overlap.put(frame, replayed.values(frame))
        if edit.id in times:
            yield times[edit.id], overlap.iou
