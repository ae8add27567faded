"""A report as CSV: a table of frames, of labels, or of people in frames."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Literal, get_args

import numpy as np

from pointbrush.work.reviewing.report.gather import Report

Table = Literal["frames", "labels", "people"]
TABLES: tuple[Table, ...] = get_args(Table)
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""A cell of words that begins so would be a formula in a spreadsheet."""
Rows = Iterator[Sequence[Any]]


def to_csv(report: Report, table: Table) -> str:
    """Return a table of the report, with a line of column names."""
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
