"""Planes of a frame: coplanar pieces that touch, such as a floor, a wall or a table top.

Noise and colours part a floor into many pieces, and the merge tree, which learnt objects, joins
them late and with what stands on them.  Here a piece joins its neighbours' plane while it lies
level with the pieces of the plane about it and has about their colour.  The comparison is local:
drift bends a scanned floor by several centimetres, more than a rug or a door is thick.
"""

from __future__ import annotations

from typing import NamedTuple

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


class _Bounds(NamedTuple):
    """Bounds of ``PlaneOptions`` for the cells of a frame: metres, cells and Lab units."""

    off: float
    rough: float
    along: float
    near: float
    colour: float
    colour_share: float
    fewest: float
    rounds: int


class _Field(NamedTuple):
    """Sums, places and colours of the pieces (P,), and their neighbours; state of the search.

    ``starts`` (P + 1,): start of a piece's neighbours in ``far``; ``plane`` (P,): -1 for none;
    ``seen`` (P,): number of the last search that met a piece; ``members``: pieces of the current
    plane, with their ``height`` over it.
    """

    leaves: Floats
    place: Floats
    tint: Floats
    starts: Ints
    far: Ints
    plane: Ints
    seen: Ints
    members: Ints
    height: Floats


def find_planes(pieces: Pieces, size: float, options: PlaneOptions) -> Ints:
    """Return the planes (3, P) of each piece, -1 for none; ``size`` of the cells, metres.

    The rows are planes that continue beyond gaps, such as a door or a table's foot, planes of
    touching pieces, and planes that leave out pictures and doors thinner than ``options.off``.
    """
    area = pieces.sums[:, sums.COUNT] * size**2
    large = np.flatnonzero(area >= options.gap_area)
    beyond = large[_near_pairs(pieces.sums[large], options.gap)]
    apart = np.concatenate([pieces.pairs, beyond])
    off = max(options.off_cells * size, options.off)
    strict = max(size, options.strict_off)
    found = [(apart, off), (pieces.pairs, off), (pieces.pairs, strict)]
    return np.stack([_partition(pieces.sums, *each, size, options) for each in found])


def _near_pairs(leaves: Floats, gap: float) -> Ints:
    """Return pairs (n, 2) of pieces with boxes at most ``gap`` metres apart."""
    low, high = leaves[:, sums.LOW : sums.HIGH], leaves[:, sums.HIGH :]
    gaps = np.maximum(np.maximum(low[:, None] - high, low - high[:, None]), 0)
    return np.argwhere(np.triu((gaps**2).sum(axis=2) <= gap**2, 1))


def _partition(leaves: Floats, pairs: Ints, off: float, size: float, options: PlaneOptions) -> Ints:
    """Return the plane (P,) of each piece, -1 for none, over ``pairs`` of pieces."""
    count = leaves[:, sums.COUNT]
    starts, far, _ = neighbours(len(count), pairs.astype(np.int32))
    order = np.argsort(-count, kind="stable")
    seeds = order[count[order] * size**2 >= options.least_seed]
    bounds = _Bounds(
        off, options.rough * off, options.along, options.near, options.colour, options.colour_share,
        options.least_area / size**2, options.rounds,
    )  # fmt: skip
    place = leaves[:, sums.XYZ : sums.SQUARES] / count[:, None]
    tint = leaves[:, sums.LAB : sums.LAB_SQUARES] / count[:, None]
    tint *= (options.lightness, 1, 1)
    plane, seen, members = (np.full(len(count), -1, np.int64) for _ in range(3))
    height = np.zeros(len(count))
    field = _Field(leaves, place, tint, starts, far, plane, seen, members, height)
    _find(field, seeds, bounds)
    return plane


@compiled
def _find(field: _Field, seeds: Ints, bounds: _Bounds) -> None:
    """Write the plane of each piece."""
    leaves, place, plane, members = field.leaves, field.place, field.plane, field.members
    total, fit = np.empty(sums.WIDTH), np.empty(4)
    found = stamp = 0
    for seed in seeds:
        if plane[seed] >= 0:
            continue
        total[:] = leaves[seed]
        before = -1.0
        held = 0
        for _ in range(bounds.rounds):
            _fit(total, fit)
            if abs(_height(place[seed], fit)) > bounds.off:
                held = 0
                break
            stamp += 1
            held = _flood(seed, field, stamp, fit, bounds)
            total[:] = leaves[seed]
            for m in members[1:held]:
                sums.add(total, leaves[m], total)
            if total[sums.COUNT] == before:
                break
            before = total[sums.COUNT]
        if held > 0 and total[sums.COUNT] >= bounds.fewest:
            for m in members[:held]:
                plane[m] = found
            found += 1


@innermost
def _flood(seed: int, field: _Field, stamp: int, fit: Floats, bounds: _Bounds) -> int:
    """Write the pieces on a plane that a seed leads to; their number."""
    leaves, place, height = field.leaves, field.place, field.height
    members, seen = field.members, field.seen
    members[0], held, at = seed, 1, 0
    seen[seed] = stamp
    height[seed] = _height(place[seed], fit)
    while at < held:
        for k in range(field.starts[members[at]], field.starts[members[at] + 1]):
            p = field.far[k]
            if seen[p] == stamp or field.plane[p] >= 0:
                continue
            seen[p] = stamp
            if _along(leaves[p], fit) < bounds.along or _rough(leaves[p], fit) > bounds.rough:
                continue
            height[p] = _height(place[p], fit)
            if _step(p, members[:held], field, bounds) <= 1:
                members[held] = p
                held += 1
        at += 1
    return held


@innermost
def _step(p: int, members: Ints, field: _Field, bounds: _Bounds) -> float:
    """Return the squared step from the members about a piece to it; 1 at the bound.

    The step has two parts: the height over the plane and the colour.
    """
    leaves, place, tint, height = field.leaves, field.place, field.tint, field.height
    raised = red = green = blue = weight = 0.0
    for m in members:
        square = 0.0
        for k in range(3):
            square += (place[m, k] - place[p, k]) ** 2
        w = leaves[m, sums.COUNT] / (1 + square / bounds.near**2) ** 2
        weight += w
        raised += w * height[m]
        red, green, blue = red + w * tint[m, 0], green + w * tint[m, 1], blue + w * tint[m, 2]
    up = height[p] - raised / weight
    colour = (tint[p, 0] - red / weight) ** 2
    colour += (tint[p, 1] - green / weight) ** 2 + (tint[p, 2] - blue / weight) ** 2
    return float((up / bounds.off) ** 2 + min(colour / bounds.colour**2, bounds.colour_share))


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
def _height(place: Floats, fit: Floats) -> float:
    """Return the signed distance of a place from a plane, metres."""
    return float(fit[0] * place[0] + fit[1] * place[1] + fit[2] * place[2] - fit[3])


@innermost
def _rough(row: Floats, fit: Floats) -> float:
    """Return the root mean square height of a region's cells over its own mean height, metres."""
    n, x, s = row[sums.COUNT], sums.XYZ, sums.SQUARES
    a, b, c = fit[0], fit[1], fit[2]
    square = (
        a * a * row[s] + b * b * row[s + 3] + c * c * row[s + 5]
        + 2 * (a * b * row[s + 1] + a * c * row[s + 2] + b * c * row[s + 4])
    ) / n  # fmt: skip
    mean = (a * row[x] + b * row[x + 1] + c * row[x + 2]) / n
    return float(np.sqrt(max(square - mean * mean, 0.0)))


@innermost
def _along(row: Floats, fit: Floats) -> float:
    """Return the share, 0 to 1, of a region's normals that points along a plane's normal."""
    n = sums.NORMAL
    dot = fit[0] * row[n] + fit[1] * row[n + 1] + fit[2] * row[n + 2]
    return float(abs(dot) / row[sums.COUNT])
