"""Sums over pieces and their boundaries, and properties of a region by its sums.

Sums are additive when pieces merge.  The merge and value models use the sums of a region.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.selection.objects.graph import Graph, eigenvalues

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Columns of a piece's sums: first additive ones, then minima and maxima.
COUNT, XYZ, SQUARES, NORMAL, LAB, LAB_SQUARES = 0, 1, 4, 10, 13, 16
ROUGH, STEEP, PERIMETER = 19, 20, 21
ADDED = 22
LOW, HIGH = 22, 25
WIDTH = 28
"""Number of a piece's sums; its z is the height above the ground."""

EDGES, TURN, CONCAVE, CONVEX, COLOUR, LENGTH = range(6)
PAIR_WIDTH = 6
"""Number of a boundary's sums."""


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """``sums`` (P, WIDTH); ``pairs`` (B, 2) neighbouring pieces, ``between`` (B, PAIR_WIDTH)."""

    sums: Floats
    pairs: Ints
    between: Floats


def sum_pieces(
    piece: Ints, place: Floats, lab: Floats, graph: Graph, bridges: Ints, across: Floats
) -> Pieces:
    """Return the sums of pieces (C,) of cells at ``place`` (C, 3): x, y, height over ground.

    ``bridges`` (B, 2): further edges, ``across`` (B, 4) as in Graph; they connect pieces, but are
    not part of the perimeter.
    """
    count = int(piece.max()) + 1 if len(piece) else 0
    sums = _piece_sums(count, piece, place, graph.normal, lab, graph.rough)
    edges = np.concatenate([graph.edges, bridges])
    values = np.concatenate([graph.across, across])
    ends = piece[edges]
    leaving = np.flatnonzero(ends[:, 0] != ends[:, 1])
    own = leaving[leaving < len(graph.edges)]
    sums[:, PERIMETER] = np.bincount(ends[own].ravel(), minlength=count)
    low, high = ends[leaving].min(axis=1), ends[leaving].max(axis=1)
    keys, pair = np.unique(low * max(count, 1) + high, return_inverse=True)
    turn, bend, colour, length = values[leaving].T
    columns = (np.ones(len(leaving)), turn, np.maximum(bend, 0), np.maximum(-bend, 0), colour)
    between = np.empty((len(keys), PAIR_WIDTH))
    for k, column in enumerate((*columns, length)):
        between[:, k] = np.bincount(pair, column, len(keys))
    return Pieces(sums, np.stack([keys // max(count, 1), keys % max(count, 1)], axis=1), between)


@compiled
def _piece_sums(
    count: int, piece: Ints, place: Floats, normal: Floats, lab: Floats, rough: Floats
) -> Floats:
    sums = np.zeros((count, WIDTH))
    sums[:, LOW:HIGH] = np.inf
    sums[:, HIGH:] = -np.inf
    for i in range(len(piece)):
        row = sums[piece[i]]
        row[COUNT] += 1
        at = SQUARES
        for k in range(3):
            row[XYZ + k] += place[i, k]
            row[NORMAL + k] += normal[i, k]
            row[LAB + k] += lab[i, k]
            row[LAB_SQUARES + k] += lab[i, k] * lab[i, k]
            row[LOW + k] = min(row[LOW + k], place[i, k])
            row[HIGH + k] = max(row[HIGH + k], place[i, k])
            for m in range(k, 3):
                row[at] += place[i, k] * place[i, m]
                at += 1
        row[ROUGH] += rough[i]
        row[STEEP] += abs(normal[i, 2])
    return sums


@innermost
def add(one: Floats, other: Floats, into: Floats) -> None:
    """Write the sums of the union of two pieces to ``into``, which may be one of them."""
    for k in range(ADDED):
        into[k] = one[k] + other[k]
    for k in range(3):
        into[LOW + k] = min(one[LOW + k], other[LOW + k])
        into[HIGH + k] = max(one[HIGH + k], other[HIGH + k])


@innermost
def extents(row: Floats, out: Floats) -> None:
    """Write the root eigenvalues of a region's spread, ascending, in metres, to ``out`` (3,)."""
    n, x, s = row[COUNT], XYZ, SQUARES
    mx, my, mz = row[x] / n, row[x + 1] / n, row[x + 2] / n
    low, middle, high = eigenvalues(
        row[s] / n - mx * mx,
        row[s + 1] / n - mx * my,
        row[s + 2] / n - mx * mz,
        row[s + 3] / n - my * my,
        row[s + 4] / n - my * mz,
        row[s + 5] / n - mz * mz,
    )
    out[0], out[1], out[2] = np.sqrt(max(low, 0)), np.sqrt(max(middle, 0)), np.sqrt(max(high, 0))


@innermost
def colour_spread(row: Floats) -> float:
    """Return the standard deviation of a region's Lab colours."""
    n, total = row[COUNT], 0.0
    for k in range(3):
        mean = row[LAB + k] / n
        total += max(row[LAB_SQUARES + k] / n - mean * mean, 0.0)
    return float(np.sqrt(total))


@innermost
def normal_length(row: Floats) -> float:
    """Return the length of the mean normal: 1 flat, 0 closed."""
    x, y, z = row[NORMAL], row[NORMAL + 1], row[NORMAL + 2]
    return float(np.sqrt(x * x + y * y + z * z) / row[COUNT])


@innermost
def box(row: Floats, out: Floats) -> None:
    """Write height, longer and shorter side of the upright box, metres, to ``out`` (3,)."""
    a = row[HIGH] - row[LOW]
    b = row[HIGH + 1] - row[LOW + 1]
    out[0], out[1], out[2] = row[HIGH + 2] - row[LOW + 2], max(a, b), min(a, b)
