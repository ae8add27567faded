"""Figures of a recording for its report."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import EditInfo, Label, LabelStore
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.reviewing.report.effort import Effort, effort_of
from pointbrush.work.reviewing.states import Overview, State, overlapping

PAGE = 1_000
F64 = NDArray[np.float64]
I64 = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """Of F frames and the labels of the palette.

    ``points``      (F,) points of each frame; ``labelled``, ``painted`` (F,) those of them with a
                    label, and those that a person painted.
    ``by_label``    label id → points (F,).
    ``confidence``  label id → (F,) 0..1, NaN where nothing was tracked.
    ``states``, ``assignees``  of each frame.
    ``effort``      by frame (None: of none) and the name of a person.
    """

    name: str
    fps: float
    palette: Sequence[Label]
    points: I64
    labelled: I64
    painted: I64
    by_label: Mapping[int, I64]
    confidence: Mapping[int, F64]
    states: Sequence[State]
    assignees: Sequence[str]
    effort: Mapping[tuple[int | None, str], Effort]

    @property
    def mean_confidence(self) -> F64:
        """(F,) mean over the labels that were tracked; NaN where none was."""
        if not self.confidence:
            return np.full(len(self.points), np.nan)
        rows = np.vstack(list(self.confidence.values()))
        there = np.isfinite(rows)
        total = np.where(there, rows, 0.0).sum(axis=0)
        count = there.sum(axis=0)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)

    def people(self) -> dict[str, Effort]:
        """Effort of each person in all frames together, who spent most first."""
        found: dict[str, Effort] = {}
        for (_, person), effort in self.effort.items():
            found.setdefault(person, Effort()).add(effort)
        return dict(sorted(found.items(), key=lambda each: -each[1].seconds))

    def per_frame(self) -> list[Effort]:
        """Effort of all people in each frame."""
        found = [Effort() for _ in self.points]
        for (frame, _), effort in self.effort.items():
            if frame is not None and frame < len(found):
                found[frame].add(effort)
        return found


def gather(
    store: LabelStore, recording: Recording, overview: Overview, name: Callable[[str], str]
) -> Report:
    """Return the report of a recording; ``name`` gives what is shown for an account."""
    sequence, frames = recording.manifest.id, len(recording)
    palette = store.palette(sequence)
    by_label = {label.id: np.zeros(frames, np.int64) for label in palette}
    painted = np.zeros(frames, np.int64)
    for (frame, label), (points, by_hand) in store.counts(sequence).items():
        if label in by_label:
            by_label[label][frame] = points
            painted[frame] += by_hand
    standing = [next(overlapping(overview, frame, frame, 0), None) for frame in range(frames)]
    effort: dict[tuple[int | None, str], Effort] = {}
    for (at, account), spent in effort_of(_edits(store, sequence)).items():
        effort.setdefault((at, name(account)), Effort()).add(spent)
    return Report(
        name=recording.manifest.name,
        fps=recording.manifest.fps,
        palette=palette,
        points=np.array(recording.manifest.points, np.int64),
        labelled=np.sum(list(by_label.values()), axis=0, dtype=np.int64)
        if by_label
        else np.zeros(frames, np.int64),
        painted=painted,
        by_label=by_label,
        confidence=_confidence(store, sequence, frames),
        states=[each.state if each else "open" for each in standing],
        assignees=[each.assignee if each else "" for each in standing],
        effort=effort,
    )


def _confidence(store: LabelStore, sequence: str, frames: int) -> dict[int, F64]:
    found: dict[int, F64] = {}
    for track in store.tracks(sequence):
        if track["state"] != "painted" and 0 <= track["frame"] < frames:
            row = found.setdefault(int(track["label"]), np.full(frames, np.nan))
            row[track["frame"]] = track["confidence"]
    return found


def _edits(store: LabelStore, sequence: str) -> Iterator[EditInfo]:
    """All edits, oldest first."""
    pages: list[list[EditInfo]] = []
    before: int | None = None
    while page := store.edits(sequence, before=before, limit=PAGE):
        pages.append(page)
        before = page[-1].revision
    for page in reversed(pages):
        yield from reversed(page)
