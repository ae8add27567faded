"""Planes of a frame: coplanar pieces that touch, such as a floor, a wall or a table top.

Noise and colours part a floor into many pieces, and the merge tree, which learnt objects, joins
them late and with what stands on them.  Here a piece joins its neighbours' plane while its cells
lie on it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.selection.objects import sums
from pointbrush.selection.objects.graph import eigenvalues, eigenvector
from pointbrush.selection.objects.growing import neighbours
from pointbrush.selection.objects.options import PlaneOptions
from pointbrush.selection.objects.sums import Pieces

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def find_planes(pieces: Pieces, size: float, options: PlaneOptions) -> Ints:
    """Return the plane (P,) of each piece, -1 for none; ``size`` of the cells, metres."""
    count = pieces.sums[:, sums.COUNT]
    starts, far, _ = neighbours(len(count), pieces.pairs.astype(np.int32))
    order = np.argsort(-count, kind="stable")
    seeds = order[count[order] * size**2 >= options.least_seed]
    fewest = options.least_area / size**2
    off = max(options.off_cells * size, options.off)
    return _planes(pieces.sums, starts, far, seeds, off, fewest, options.rounds)


@compiled
def _planes(
    leaves: Floats, starts: Ints, far: Ints, seeds: Ints, off: float, fewest: float, rounds: int
) -> Ints:
    plane = np.full(len(leaves), -1, np.int64)
    seen = np.full(len(leaves), -1, np.int64)
    members = np.empty(len(leaves), np.int64)
    total, fit = np.empty(sums.WIDTH), np.empty(4)
    found = stamp = 0
    for seed in seeds:
        if plane[seed] >= 0:
            continue
        total[:] = leaves[seed]
        before = -1.0
        held = 0
        for _ in range(rounds):
            _fit(total, fit)
            if _off(leaves[seed], fit) > off:
                held = 0
                break
            stamp += 1
            held = _flood(seed, leaves, starts, far, plane, seen, stamp, fit, off, members)
            total[:] = leaves[seed]
            for m in members[1:held]:
                sums.add(total, leaves[m], total)
            if total[sums.COUNT] == before:
                break
            before = total[sums.COUNT]
        if held > 0 and total[sums.COUNT] >= fewest:
            for m in members[:held]:
                plane[m] = found
            found += 1
    return plane


@innermost
def _flood(
    seed: int,
    leaves: Floats,
    starts: Ints,
    far: Ints,
    plane: Ints,
    seen: Ints,
    stamp: int,
    fit: Floats,
    off: float,
    members: Ints,
) -> int:
    """Write the pieces on a plane that a seed leads to; their number."""
    members[0], held, at = seed, 1, 0
    seen[seed] = stamp
    while at < held:
        for k in range(starts[members[at]], starts[members[at] + 1]):
            p = far[k]
            if seen[p] != stamp and plane[p] < 0:
                seen[p] = stamp
                if _off(leaves[p], fit) <= off:
                    members[held] = p
                    held += 1
        at += 1
    return held


@innermost
def _fit(row: Floats, fit: Floats) -> None:
    """Write the normal of a region's plane, and its distance from the origin."""
    n, x, s = row[sums.COUNT], sums.XYZ, sums.SQUARES
    a, b, c = row[x] / n, row[x + 1] / n, row[x + 2] / n
    xx, xy, xz = row[s] / n - a * a, row[s + 1] / n - a * b, row[s + 2] / n - a * c
    yy, yz, zz = row[s + 3] / n - b * b, row[s + 4] / n - b * c, row[s + 5] / n - c * c
    least = eigenvalues(xx, xy, xz, yy, yz, zz)[0]
    fit[0], fit[1], fit[2] = eigenvector(xx, xy, xz, yy, yz, zz, least)
    fit[3] = fit[0] * a + fit[1] * b + fit[2] * c


@innermost
def _off(row: Floats, fit: Floats) -> float:
    """Root mean square distance of a region's cells from a plane, metres."""
    n, x, s = row[sums.COUNT], sums.XYZ, sums.SQUARES
    a, b, c, d = fit[0], fit[1], fit[2], fit[3]
    square = (
        a * a * row[s] + b * b * row[s + 3] + c * c * row[s + 5]
        + 2 * (a * b * row[s + 1] + a * c * row[s + 2] + b * c * row[s + 4])
    ) / n  # fmt: skip
    mean = (a * row[x] + b * row[x + 1] + c * row[x + 2]) / n
    return float(np.sqrt(max(square - 2 * d * mean + d * d, 0.0)))
