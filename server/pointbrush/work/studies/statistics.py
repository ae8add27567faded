"""Differences between conditions: effect sizes with bootstrap intervals."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
RESAMPLES = 2_000
"""Bootstrap samples of an interval."""
COVERAGE = 0.95


@dataclass(frozen=True, slots=True)
class Effect:
    """Difference of a measure between two conditions: second minus first, with 95% intervals.

    ``d``: Cohen's d, of paired differences within participants (d_z), else with the pooled
    deviation.  ``count``: participants in both, or in either group; None: too few.
    """

    measure: str
    first: str
    second: str
    count: int
    difference: float
    interval: tuple[float, float]
    d: float
    d_interval: tuple[float, float]


def by_participant(rows: Sequence[dict[str, Any]], measure: str) -> dict[str, dict[int, float]]:
    """Return the mean of a measure over tasks by condition and participant; None is left out."""
    found: dict[tuple[str, int], list[float]] = defaultdict(list)
    for row in rows:
        if isinstance(row.get(measure), int | float):
            found[row["condition"], row["participant"]].append(row[measure])
    means: dict[str, dict[int, float]] = defaultdict(dict)
    for (condition, participant), values in found.items():
        means[condition][participant] = float(np.mean(values))
    return means


def effects(
    rows: Sequence[dict[str, Any]], measure: str, conditions: Sequence[str], *, paired: bool,
    seed: int,
) -> list[Effect]:  # fmt: skip
    """Return the effects of all pairs of ``conditions`` with enough participants, in order."""
    means = by_participant(rows, measure)
    found = []
    for first, second in combinations(filter(means.__contains__, conditions), 2):
        if paired:
            both = sorted(means[first].keys() & means[second].keys())
            groups = [np.array([means[name][n] for n in both]) for name in (first, second)]
        else:
            groups = [np.array([*means[name].values()]) for name in (first, second)]
        if min(map(len, groups)) >= 2:
            found.append(_effect(measure, first, second, groups, paired=paired, seed=seed))
    return found


def _effect(
    measure: str, first: str, second: str, groups: list[F64], *, paired: bool, seed: int
) -> Effect:
    random = np.random.default_rng(seed)
    samples = []
    for _ in range(RESAMPLES):
        drawn = [random.integers(0, len(each), len(each)) for each in groups]
        drawn = [drawn[0], drawn[0]] if paired else drawn
        first_drawn, second_drawn = (g[d] for g, d in zip(groups, drawn, strict=True))
        samples.append(_size(first_drawn, second_drawn, paired=paired))
    edges = [100 * (1 - COVERAGE) / 2, 100 * (1 + COVERAGE) / 2]
    differences, sizes = np.array(samples).T
    known = sizes[np.isfinite(sizes)]
    count = len(groups[0]) if paired else sum(map(len, groups))
    difference, d = _size(groups[0], groups[1], paired=paired)
    low, high = np.percentile(differences, edges).tolist()
    d_low, d_high = np.percentile(known, edges).tolist() if len(known) else (np.nan, np.nan)
    return Effect(measure, first, second, count, difference, (low, high), d, (d_low, d_high))


def _size(first: F64, second: F64, *, paired: bool) -> tuple[float, float]:
    """Return the difference of means and Cohen's d; infinite or NaN without any deviation."""
    difference = float(second.mean() - first.mean())
    if paired:
        spread = float((second - first).std(ddof=1))
    else:
        degrees = len(first) + len(second) - 2
        total = (len(first) - 1) * first.var(ddof=1) + (len(second) - 1) * second.var(ddof=1)
        spread = float(np.sqrt(total / degrees))
    return difference, difference / spread if spread > 0 else np.nan
