"""The report of a study: a single HTML file with plots, without external resources."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from pointbrush.values.study import Study
from pointbrush.work.reviewing.report import plots
from pointbrush.work.reviewing.report.html import legend, page, table
from pointbrush.work.reviewing.report.plots import Series
from pointbrush.work.studies.overlap import Point
from pointbrush.work.studies.results import Row, at_seconds
from pointbrush.work.studies.statistics import by_participant, effects

COLORS = ("#3b82f6", "#e07a1f", "#2e9e6b", "#9b5de5", "#d9534f", "#0f9bb0")
MEASURES = (
    "duration_s", "iou", "time_to_80_s", "time_to_90_s", "strokes", "undos", "head_m", "left_m",
    "right_m", "navigation", "painting", "waiting",
)  # fmt: skip
"""Columns of the results that are compared, besides the scores."""
NOTE = (
    "Means over participants. A difference is the second condition minus the first, with the "
    "interval that holds 95% of 2,000 bootstrap samples of participants. d is Cohen's d"
)


def to_html(study: Study, results: Sequence[tuple[Row, Sequence[Point]]]) -> str:
    """Return the report as a page."""
    colors = {each.name: COLORS[n % len(COLORS)] for n, each in enumerate(study.conditions)}
    people = len({row["participant"] for row, _ in results})
    about = f"{people} participants, {len(results)} finished tasks, {study.design} participants"
    rows = [row for row, _ in results]
    return page(study.title, about, _curves(study, results, colors) + _means(study, rows, colors))


def _curves(
    study: Study, results: Sequence[tuple[Row, Sequence[Point]]], colors: Mapping[str, str]
) -> str:
    """Return a plot of the mean IoU over time for each task."""
    parts = "<h2>IoU over time</h2><p class='soft'>Mean of the participants, by seconds</p>"
    for task in study.tasks:
        curves: dict[str, list[Sequence[Point]]] = defaultdict(list)
        for row, curve in results:
            if row["task"] == task.name:
                curves[row["condition"]].append(curve)
        longest = max((r["duration_s"] for r, _ in results if r["task"] == task.name), default=0)
        seconds = math.ceil(longest)
        series = [
            Series(name, color, np.mean([at_seconds(c, seconds) for c in curves[name]], axis=0))
            for name, color in colors.items()
            if name in curves
        ]
        if series:
            parts += f"<h3>{escape(task.name)}</h3>"
            parts += plots.lines(series, seconds + 1, top=1.0, unit="")
    return parts + legend(colors.items())


def _means(study: Study, rows: Sequence[Row], colors: Mapping[str, str]) -> str:
    bars, lines = "", list[tuple[str, ...]]()
    for measure in (*MEASURES, *(each.name for each in study.questionnaires)):
        own = by_participant(rows, measure)
        means = {name: float(np.mean([*own[name].values()])) for name in colors if name in own}
        if means:
            bars += f"<h3>{escape(measure)}</h3>" + plots.named_bars([
                (name, colors[name], mean, f"{mean:.3g} (n = {len(own[name])})")
                for name, mean in means.items()
            ])  # fmt: skip
        for each in effects(
            rows, measure, [*colors], paired=study.design == "within", seed=study.seed
        ):
            lines.append((
                measure, f"{each.second} – {each.first}", str(each.count),
                _with_interval(each.difference, each.interval),
                _with_interval(each.d, each.d_interval),
            ))  # fmt: skip
    head = ("measure", "conditions", "n", "difference", "d")
    kind = "of the paired differences" if study.design == "within" else "with the pooled deviation"
    note = f"<h2>Measures</h2><p class='soft'>{NOTE} {kind}.</p>"
    return f"{note}{table(head, lines)}{bars}"


def _with_interval(value: float, interval: tuple[float, float]) -> str:
    if not math.isfinite(value):
        return "–"
    return f"{value:.3g} [{interval[0]:.3g}, {interval[1]:.3g}]"
