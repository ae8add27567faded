"""Statistics of a recording for its report, and CSV tables of them.

People's seconds and strokes per frame are computed from the times of their edits.
"""

from __future__ import annotations

import csv
import io
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import EditInfo, Label, LabelStore
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.team.review import ReviewOverview
from pointbrush.work.reviewing.states import State, overlapping

STROKES = frozenset({"paint", "erase", "delete", "restore"})
MACHINE = frozenset({"tracking", "import"})
"""Kinds of automatic edits, which are not counted as work."""
PAGE = 1_000
F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
Table = Literal["frames", "labels", "people"]
TABLES: tuple[Table, ...] = get_args(Table)
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Prefixes with which a text cell would be a formula in a spreadsheet."""
Rows = Iterator[Sequence[Any]]


@dataclass(frozen=True, slots=True)
class EffortOptions:
    """``idle`` seconds without an edit are a pause; ``first``: seconds for an edit after it."""

    idle: float = 60.0
    first: float = 5.0


@dataclass(slots=True)
class Effort:
    """Seconds, strokes and edits of a person in a frame, or a sum of them."""

    seconds: float = 0.0
    strokes: int = 0
    edits: int = 0

    def add(self, other: Effort) -> None:
        """Add another effort."""
        self.seconds += other.seconds
        self.strokes += other.strokes
        self.edits += other.edits


def effort_of(
    edits: Iterable[EditInfo], options: EffortOptions | None = None
) -> Mapping[tuple[int | None, str], Effort]:
    """Return effort by frame and author; frame None: edits without a frame, as of the palette.

    ``edits`` are in chronological order.  The time since an author's last edit is divided equally
    between the frames of the next edit; each frame counts its stroke.
    """
    options = options or EffortOptions()
    last: dict[str, float] = {}
    found: dict[tuple[int | None, str], Effort] = defaultdict(Effort)
    for edit in edits:
        if edit.kind in MACHINE:
            continue
        time = edit.time.timestamp()
        gap = time - last.get(edit.author, float("-inf"))
        seconds = gap if 0 <= gap <= options.idle else options.first
        last[edit.author] = time
        frames: tuple[int | None, ...] = edit.frames or (None,)
        for frame in frames:
            stroke = int(edit.kind in STROKES and frame is not None)
            found[frame, edit.author].add(Effort(seconds / len(frames), stroke, 1))
    return dict(found)


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """Statistics of F frames and the labels of the palette.

    ``points``      (F,) points of each frame; ``labelled``, ``painted`` (F,) labelled points and
                    painted points among them.
    ``by_label``    label id → points (F,).
    ``confidence``  label id → (F,) 0..1, NaN without a track.
    ``states``, ``assignees``  of each frame.
    ``effort``      by frame (None: without a frame) and the name of a person.
    """

    name: str
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
        """Return the mean (F,) over tracked labels; NaN: none."""
        if not self.confidence:
            return np.full(len(self.points), np.nan)
        rows = np.vstack(list(self.confidence.values()))
        there = np.isfinite(rows)
        total = np.where(there, rows, 0.0).sum(axis=0)
        count = there.sum(axis=0)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)

    def people(self) -> dict[str, Effort]:
        """Return the effort of each person in all frames, longest time first."""
        found: dict[str, Effort] = {}
        for (_, person), effort in self.effort.items():
            found.setdefault(person, Effort()).add(effort)
        return dict(sorted(found.items(), key=lambda each: -each[1].seconds))

    def per_frame(self) -> list[Effort]:
        """Return the effort of all people in each frame."""
        found = [Effort() for _ in self.points]
        for (frame, _), effort in self.effort.items():
            if frame is not None and frame < len(found):
                found[frame].add(effort)
        return found


def gather(
    store: LabelStore, recording: Recording, overview: ReviewOverview, name: Callable[[str], str]
) -> Report:
    """Return the report of a recording; ``name`` returns the name of an account."""
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
    """Yield all edits, oldest first."""
    pages: list[list[EditInfo]] = []
    before: int | None = None
    while page := store.edits(sequence, before=before, limit=PAGE):
        pages.append(page)
        before = page[-1].revision
    for page in reversed(pages):
        yield from reversed(page)


def to_csv(report: Report, table: Table) -> str:
    """Return a table of the report with a header line."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    for row in WRITERS[table](report):
        writer.writerow([_cell(value) for value in row])
    return out.getvalue()


def _frames(report: Report) -> Rows:
    yield (
        "frame", "state", "assignee", "points", "labelled", "painted", "confidence", "seconds",
        "strokes",
    )  # fmt: skip
    confidence, effort = report.mean_confidence, report.per_frame()
    for frame, points in enumerate(report.points.tolist()):
        yield (
            frame, report.states[frame], report.assignees[frame], points,
            int(report.labelled[frame]), int(report.painted[frame]), float(confidence[frame]),
            effort[frame].seconds, effort[frame].strokes,
        )  # fmt: skip


def _labels(report: Report) -> Rows:
    yield "label", "name", "category", "color", "frames", "points", "confidence"
    for label in report.palette:
        points = report.by_label[label.id]
        known = report.confidence.get(label.id, np.array([]))
        known = known[np.isfinite(known)]
        mean = float(known.mean()) if len(known) else float("nan")
        yield (
            label.id, label.name, label.category, label.color, int((points > 0).sum()),
            int(points.sum()), mean,
        )  # fmt: skip


def _people(report: Report) -> Rows:
    yield "frame", "person", "seconds", "strokes", "edits"
    for (frame, person), effort in sorted(
        report.effort.items(), key=lambda each: (each[0][0] is None, each[0][0] or 0, each[0][1])
    ):
        place = "" if frame is None else frame
        yield place, person, effort.seconds, effort.strokes, effort.edits


def _cell(value: object) -> object:
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.3f}"
    if isinstance(value, str) and value.startswith(FORMULA):
        return f"'{value}"
    return value


WRITERS: dict[Table, Callable[[Report], Rows]] = {
    "frames": _frames,
    "labels": _labels,
    "people": _people,
}
