"""Features of two neighbouring pieces for the merge model: the smaller a, the larger b."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import innermost
from pointbrush.selection.objects import shape, sums

Floats = NDArray[np.float64]
FEATURES = 44
"""Numbers of a pair."""
TINY = 1e-6


@innermost
def pair_features(
    a: Floats, b: Floats, pair: Floats, area: float, work: Floats, out: Floats
) -> None:
    """Write the 44 numbers of a pair to ``out``.

    ``a``, ``b`` sums of the smaller and the larger piece, ``pair`` of their boundary; ``area``
    of a cell, square metres; ``work`` (3, WIDTH) scratch.
    """
    na, nb, m = a[sums.COUNT], b[sums.COUNT], pair[sums.EDGES]
    out[0], out[1] = np.log(na * area), np.log(nb * area)
    out[2] = m / max(a[sums.PERIMETER], 1.0)
    out[3] = m / max(b[sums.PERIMETER], 1.0)
    out[4] = m / np.sqrt(na)
    for k in range(4):
        out[5 + k] = pair[sums.TURN + k] / m
    out[9] = pair[sums.LENGTH] / m / np.sqrt(area)
    _colours(a, b, out)
    _normals(a, b, out)
    _extents(a, b, work, out)
    out[28], out[29] = a[sums.ROUGH] / na, b[sums.ROUGH] / nb
    out[30], out[31] = a[sums.STEEP] / na, b[sums.STEEP] / nb
    z = sums.XYZ + 2
    out[32] = b[z] / nb - a[z] / na
    low, high = sums.LOW + 2, sums.HIGH + 2
    out[33], out[34] = a[low], b[low]
    out[35], out[36] = b[low] - a[low], b[high] - a[high]
    shape.box(work[0], work[1])
    out[37], out[38], out[39] = work[1][0], work[1][1], work[1][2]
    shape.box(b, work[1])
    out[40], out[41] = out[37] - work[1][0], out[38] - work[1][1]
    out[42], out[43] = a[high], np.log(na / nb)


@innermost
def _colours(a: Floats, b: Floats, out: Floats) -> None:
    na, nb, apart = a[sums.COUNT], b[sums.COUNT], 0.0
    for k in range(3):
        step = abs(a[sums.LAB + k] / na - b[sums.LAB + k] / nb)
        if k == 0:
            out[10] = step
        else:
            apart += step * step
    out[11] = np.sqrt(apart)
    out[12], out[13] = shape.colour_spread(a), shape.colour_spread(b)
    out[14] = np.sqrt(out[10] * out[10] + apart) / (1.0 + out[12] + out[13])


@innermost
def _normals(a: Floats, b: Floats, out: Floats) -> None:
    na, nb = a[sums.COUNT], b[sums.COUNT]
    way = dot = one = other = 0.0
    for k in range(3):
        step = b[sums.XYZ + k] / nb - a[sums.XYZ + k] / na
        p, q = a[sums.NORMAL + k] / na, b[sums.NORMAL + k] / nb
        way += step * step
        dot += p * q
        one += p * step
        other += q * step
    way = np.sqrt(way)
    out[15], out[16] = shape.normal_length(a), shape.normal_length(b)
    out[17] = dot / max(out[15] * out[16], TINY)
    out[18], out[19] = one / max(way, TINY), other / max(way, TINY)
    out[20] = out[18] - out[19]
    out[21] = way


@innermost
def _extents(a: Floats, b: Floats, work: Floats, out: Floats) -> None:
    """Write how far a, b and both reach; leaves the union's sums in ``work[0]``."""
    shape.extents(a, work[1])
    long_a = work[1][2]
    out[22], out[23] = work[1][0], long_a
    shape.extents(b, work[1])
    out[24] = work[1][0]
    sums.add(a, b, work[0])
    shape.extents(work[0], work[2])
    out[25], out[26] = work[2][0], work[2][2] - work[1][2]
    out[27] = out[21] / max(long_a + work[1][2], TINY)
