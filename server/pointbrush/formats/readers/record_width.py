"""Recognition of records of three floats, x y z, by the distributions of their values."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
# As many floats as make whole points of records of 4 and 6.
SAMPLE = 48_000
FEW = SAMPLE // 8
"""Floats that are compared by their distributions."""
LEAST = 36
"""Least number of records for a comparison of distributions."""
MORE_MIXED = 1.5
"""Least ratio of the difference within columns for a wrong width to that for the right one."""
LITTLE_MIXED = 0.15
"""Difference within columns below which widths are not distinguished."""
MOST_APART = 0.1
"""Greatest difference of a coordinate's distributions between every other record."""


def sample(data: bytes, width: int) -> Floats:
    """Return the first records of ``width`` floats each."""
    count = min(len(data) // 4, SAMPLE) // width * width
    return np.frombuffer(data, "<f4", count).reshape(-1, width)


def is_xyz(data: bytes) -> bool:
    """Return whether records have only coordinates, and no other number of floats fits.

    With the right number of floats, the values of a column have one distribution; with another
    number, every column mixes several distributions.
    """
    table = sample(data, 3)
    if len(data) % 12 or len(table) < LEAST or not (np.abs(table) < 1e7).all():
        return False
    known = table[table != 0]
    if not known.size or (known % 1 == 0).mean() > 0.5 or np.median(np.abs(known)) < 1e-4:
        return False
    if not all(_fits_three(data, width) for width in (4, 5, 7)):
        return False
    # In records of 6 or 9 floats, every second or third one here has no coordinates (normals, …).
    return not any(len(data) % (12 * step) == 0 and _takes_turns(table, step) for step in (2, 3))


def _takes_turns(table: Floats, step: int) -> bool:
    """Return whether two columns differ in distribution between every ``step``-th and next record.

    A single column may differ: the heights of lasers that measure in turn.
    """
    apart = sorted(_distance(table[::step, i], table[1::step, i]) for i in range(3))
    # Few values differ by chance.
    return bool(apart[1] > MOST_APART + 1.5 / np.sqrt(len(table) / step))


def _fits_three(data: bytes, width: int) -> bool:
    """Return whether three floats a record fit better than ``width``, or ``width`` is impossible.

    In a truncated file, another width is still visible in the distributions.
    """
    mine, other = _mixed(data, 3, width), _mixed(data, width, 3)
    silent = len(data) % (4 * width) != 0 and max(mine, other) < LITTLE_MIXED
    return silent or other > MORE_MIXED * mine


def _mixed(data: bytes, width: int, records: int) -> float:
    """Return the mean distance of a column's distributions in one of ``records`` and another."""
    table = sample(data[: 4 * FEW], width * records)
    pairs = [(i, k) for i, k in combinations(range(width * records), 2) if i % width == k % width]
    return float(np.mean([_distance(table[:, i], table[:, k]) for i, k in pairs]))


def _distance(a: Floats, b: Floats) -> float:
    """Greatest difference of two cumulative distributions (Kolmogorov and Smirnov), 0 to 1."""
    both = np.concatenate([a, b])
    shares = [np.searchsorted(np.sort(each), both, "right") / len(each) for each in (a, b)]
    return float(np.abs(shares[0] - shares[1]).max())
