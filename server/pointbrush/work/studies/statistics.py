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
Interval = tuple[float, float]
RESAMPLES = 2_000
"""Bootstrap samples of an interval."""
EDGES = (2.5, 97.5)
"""Percentiles at the ends of an interval."""


@dataclass(frozen=True, slots=True)
class Effect:
    """Difference of a measure between two conditions: second minus first, with 95% intervals.

    ``d``: Cohen's d, of paired differences within participants (d_z), else with the pooled
    deviation; NaN without any deviation.  ``count``: participants in both, or in either group.
    """

    first: str
    second: str
    count: int
    difference: float
    interval: Interval
    d: float
    d_interval: Interval


def by_participant(rows: Sequence[dict[str, Any]], measure: str) -> dict[str, dict[int, float]]:
    """Return the mean of a measure over tasks by condition and participant; None is left out."""
    found: dict[str, dict[int, list[float]]] = defaultdict(lambda: defaultdict(list))
    for row in rows:
        if isinstance(row.get(measure), int | float):
            found[row["condition"]][row["participant"]].append(row[measure])
    return {
        condition: {participant: float(np.mean(values)) for participant, values in own.items()}
        for condition, own in found.items()
    }


def effects(
    rows: Sequence[dict[str, Any]], measure: str, conditions: Sequence[str], *, paired: bool,
    seed: int,
) -> list[Effect]:  # fmt: skip
    """Return the effects of all pairs of ``conditions`` with enough participants, in order."""
    means = by_participant(rows, measure)
    found = []
    for first, second in combinations(filter(means.__contains__, conditions), 2):
        own, other = means[first], means[second]
        if paired:
            groups = [np.array([other[n] - own[n] for n in own if n in other])]
        else:
            groups = [np.array([*own.values()]), np.array([*other.values()])]
        if min(map(len, groups)) >= 2:
            found.append(_effect(first, second, groups, seed))
    return found


def _effect(first: str, second: str, groups: Sequence[F64], seed: int) -> Effect:
    random = np.random.default_rng(seed)
    drawn = [each[random.integers(len(each), size=(RESAMPLES, len(each)))] for each in groups]
    differences, sizes = _sizes(drawn)
    difference, d = map(float, _sizes(groups))
    low, high = np.percentile(differences, EDGES).tolist()
    d_low, d_high = (d, d) if np.isnan(d) else np.nanpercentile(sizes, EDGES).tolist()
    count = sum(map(len, groups))
    return Effect(first, second, count, difference, (low, high), d, (d_low, d_high))


def _sizes(groups: Sequence[F64]) -> tuple[F64, F64]:
    """Return the difference of means, and Cohen's d, along the last axis.

    ``groups``: paired differences, or the values of the first and second condition.
    """
    difference = groups[-1].mean(-1) - (groups[0].mean(-1) if len(groups) == 2 else 0.0)
    degrees = [each.shape[-1] - 1 for each in groups]
    squares = sum(n * each.var(-1, ddof=1) for n, each in zip(degrees, groups, strict=True))
    spread = np.sqrt(squares / sum(degrees))
    return difference, difference / np.where(spread > 0, spread, np.nan)
