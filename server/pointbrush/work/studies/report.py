"""The report of a study: a single HTML file with plots, without external resources."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np

from pointbrush.values.study import Study
from pointbrush.work.reviewing.report import plots
from pointbrush.work.reviewing.report.html import STYLE, legend, table
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
    title = escape(study.title)
    people = len({row["participant"] for row, _ in results})
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f"<style>{STYLE}</style></head><body><header><h1>{title}</h1>"
        f'<p class="soft">{people} participants, {len(results)} finished tasks, '
        f"{study.design} participants</p></header>"
        f"{_curves(study, results)}{_means(study, [row for row, _ in results])}</body></html>\n"
    )


def _curves(study: Study, results: Sequence[tuple[Row, Sequence[Point]]]) -> str:
    """Return a plot of the mean IoU over time for each task."""
    names = [each.name for each in study.conditions]
    shown = [(name, COLORS[n % len(COLORS)]) for n, name in enumerate(names)]
    parts = "<h2>IoU over time</h2><p class='soft'>Mean of the participants, by seconds</p>"
    for task in study.tasks:
        mine = [(row, curve) for row, curve in results if row["task"] == task.name]
        if not mine:
            continue
        seconds = math.ceil(max(row["duration_s"] for row, _ in mine))
        series = []
        for name, color in shown:
            lines = [at_seconds(curve, seconds) for row, curve in mine if row["condition"] == name]
            if lines:
                series.append(Series(name, color, np.mean(lines, axis=0)))
        parts += f"<p>{escape(task.name)}</p>" + plots.lines(series, seconds + 1, top=1.0, unit="")
    return parts + legend(shown)


def _means(study: Study, rows: Sequence[Row]) -> str:
    names = [each.name for each in study.conditions]
    paired, bars = study.design == "within", ""
    lines: list[tuple[str, ...]] = []
    for measure in (*MEASURES, *(each.name for each in study.questionnaires)):
        means = [
            (name, COLORS[n % len(COLORS)], float(np.mean([*own.values()])), f"n = {len(own)}")
            for n, name in enumerate(names)
            if (own := by_participant(rows, measure).get(name))
        ]
        if means:
            bars += f"<p>{escape(measure)}</p>" + plots.named_bars(
                [(name, color, mean, f"{mean:.3g} ({n})") for name, color, mean, n in means]
            )
        lines += [
            (
                measure,
                f"{each.second} – {each.first}",
                str(each.count),
                _with_interval(each.difference, each.interval),
                _with_interval(each.d, each.d_interval),
            )
            for each in effects(rows, measure, names, paired=paired, seed=study.seed)
        ]
    head = ("measure", "conditions", "n", "difference", "d")
    kind = "of the paired differences." if paired else "with the pooled deviation."
    return f"<h2>Measures</h2><p class='soft'>{NOTE} {kind}</p>{table(head, lines)}{bars}"


def _with_interval(value: float, interval: tuple[float, float]) -> str:
    if not math.isfinite(value):
        return "–"
    return f"{value:.3g} [{interval[0]:.3g}, {interval[1]:.3g}]"
