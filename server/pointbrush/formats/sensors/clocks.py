"""Estimate of the clock offset of two sensors from motion that both see."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import PointFrame

Signal = NDArray[np.float64]
MOST_FRAMES = 300
"""Frames of each sensor that are read."""
CELLS = 40
"""Cells along the width of the first frame, in which points are counted."""
STEPS = 8
"""Steps of the offset in a period of the sensor with more frames."""
LEAST_OVERLAP = 0.5
"""Least share of the shorter recording for which both must record at an offset."""
LEAST_CHANGES = 10
"""Least number of changes of each sensor."""
LEAST = 0.6
"""Least correlation of the changes that both sensors see."""
LEAST_SCORE = 4.5
"""Least significance: Fisher's z of the correlation, in its standard deviations without motion.
With some 100 offsets to choose from, noise reaches 3.5."""
LEAST_LEAD = 1.0
"""Least lead of the significance over that of offsets more than two periods away."""
MOST_OFFSETS = 20_000
"""Most offsets to try; only a gap in the times of some frames gives more."""


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """Seconds to add to the times of a sensor, and the correlation of changes by it.

    ``is_clear``: the correlation is high, and less significant at other offsets.
    """

    seconds: float
    correlation: float
    is_clear: bool


def changes(frames: Iterable[PointFrame]) -> Signal:
    """Return the share of points that change their cell from each frame to the next."""
    counts: list[tuple[NDArray[np.int64], Signal]] = []
    size = 0.0
    for frame in frames:
        if not size:
            size = max(float(np.ptp(np.quantile(frame.xyz, (0.05, 0.95), axis=0), axis=0).max()), 1)
        cells = np.floor(frame.xyz * (CELLS / size)).astype(np.int64) & 0xFFFF
        keys, number = np.unique(cells @ (1, 1 << 16, 1 << 32), return_counts=True)
        counts.append((keys, number / max(len(frame), 1)))
    return np.array([_difference(*pair) for pair in pairwise(counts)])


def _difference(
    before: tuple[NDArray[np.int64], Signal], after: tuple[NDArray[np.int64], Signal]
) -> float:
    keys, place = np.unique(np.concatenate([before[0], after[0]]), return_inverse=True)
    signed = np.concatenate([-before[1], after[1]])
    return float(np.abs(np.bincount(place, signed, len(keys))).sum()) / 2


def clock_offset(
    reference: Signal, at: Sequence[float], other: Signal, times: Sequence[float]
) -> ClockOffset:
    """Estimate the offset of a sensor from ``changes`` of both and the times of their frames."""
    if min(len(reference), len(other)) < LEAST_CHANGES:
        return ClockOffset(0.0, 0.0, False)
    a, b = (np.array(t[: len(s) + 1]) for s, t in ((reference, at), (other, times)))
    a, b = (a[1:] + a[:-1]) / 2, (b[1:] + b[:-1]) / 2
    periods = [float(np.median(np.diff(each))) for each in (a, b)]
    step = min(periods) / STEPS
    least = LEAST_OVERLAP * min(np.ptp(a), np.ptp(b))
    first, last = a[0] - b[-1] + least, a[-1] - b[0] - least
    if not 0 < last - first < MOST_OFFSETS * step:
        return ClockOffset(0.0, 0.0, False)
    offsets = np.arange(first, last + step, step)
    found, count = np.array([_correlation(reference, a, other, b + each) for each in offsets]).T
    score = np.arctanh(found.clip(-0.999, 0.999)) * np.sqrt(np.maximum(count - 3, 0))
    best = int(score.argmax())
    away = score[np.abs(offsets - offsets[best]) > 2 * max(periods)]
    lead = score[best] - away.max(initial=0.0)
    peak = found[max(best - 1, 0) : best + 2]
    bend = peak[0] - 2 * peak[1] + peak[-1] if len(peak) == 3 else 0.0
    shift = step * (peak[0] - peak[-1]) / (2 * bend) if bend < 0 else 0.0
    clear = found[best] >= LEAST and score[best] >= LEAST_SCORE and lead >= LEAST_LEAD
    return ClockOffset(float(offsets[best] + shift), float(found[best]), bool(clear))


def _correlation(reference: Signal, a: Signal, other: Signal, b: Signal) -> tuple[float, int]:
    """Return the correlation of two signals while both are known, 0 for constant ones, and the
    number of their values.
    """
    inside = (a >= b[0]) & (a <= b[-1])
    first, second = reference[inside], np.interp(a[inside], b, other)
    if len(first) < 3 or not (np.std(first) > 0 and np.std(second) > 0):
        return 0.0, len(first)
    return float(np.corrcoef(first, second)[0, 1]), len(first)
