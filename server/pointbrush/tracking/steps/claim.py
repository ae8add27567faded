"""Points that registered tracks claim, with flying pixels and outlines."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.columns import NONE, columns, nearest_three
from pointbrush.tracking.compute.grid import bounds, within
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.sensors.camera import I32
from pointbrush.tracking.sensors.view import View


class FlyingRule(NamedTuple):
    """Rule for a flying pixel: it lies ``behind`` metres behind an adjacent pixel.

    At most ``few`` pixels of the object, within ``reach`` pixels, have its depth within ``level``
    metres.  The ``margin`` rows at the edge of the picture are excluded.
    """

    behind: float
    level: float
    reach: int
    few: int
    margin: int


def flying(view: View, points: I64, unit: float) -> Mask:
    """Mark the flying pixels among the ``points`` (M,) of an object.

    They lie behind other points of it, without neighbours at their depth.  ``unit``: tolerance (m).
    There are none for a sensor without depth images.
    """
    if view.lens is None or not view.lens.lattice or not len(points):
        return np.zeros(len(points), np.bool_)
    return _loose(view, points, view.marked(points), unit)


def painted_with_flying(view: View, points: I64, unit: float) -> bool:
    """Return whether most flying pixels at the outline of painted ``points`` (M,) are painted too.

    Painting by an outline in a picture includes the flying pixels inside it.
    """
    options = view.options.flying
    if view.lens is None or not view.lens.lattice:
        return False
    cell = view.cells.cell
    near = np.flatnonzero(view.around(points)[cell])
    loose = near[_loose(view, near, np.isfinite(view.depth), unit)]
    return (
        len(loose) >= options.min_pixels
        and float(view.marked(points)[cell[loose]].mean()) > options.painted_share
    )


def _loose(view: View, points: I64, own: Mask, unit: float) -> Mask:
    options = view.options.flying
    cell, depth = view.cells.pick(points)
    rule = FlyingRule(
        options.behind_units * unit, options.level_units * unit, reach=1, few=0, margin=0
    )
    return lies_behind(cell, depth, view.depth, own, view.camera.shape[1], rule)


@compiled
def lies_behind(
    cells: I32, depths: F32, image: F32, own: Mask, width: int, rule: FlyingRule
) -> Mask:
    """Mark the flying pixels (M,): behind a pixel of the object, at a depth with few others of it.

    ``own`` (cells + 1,): mask of the object's pixels in the depth ``image``, rows of ``width``.
    """
    result = np.zeros(len(cells), np.bool_)
    border = rule.margin * (width + 1)
    for i in range(len(cells)):
        cell, like, behind = cells[i], 0, False
        if not border <= cell < len(image) - 1 - border:
            continue
        for row in range(-rule.reach, rule.reach + 1):
            for column in range(-rule.reach, rule.reach + 1):
                other = cell + row * width + column
                # Wrapping at image borders is harmless: these pixels are far from the object.
                if other == cell or other < 0 or other >= len(image) or not own[other]:
                    continue
                difference = depths[i] - image[other]
                like += abs(difference) < rule.level
                behind |= difference > rule.behind and abs(row) < 2 and abs(column) < 2
        result[i] = behind and like <= rule.few
    return result


def outline(view: View, own: I64, rest: I64, unit: float) -> tuple[Mask, Mask]:
    """Mark the flying pixels among an object's points ``own`` (M,), and its rim in ``rest`` (N,).

    ``unit``: tolerance (m).  It needs a camera.
    """
    options = view.options.flying
    cell, depth = view.cells
    image, width = view.depth, view.camera.shape[1]
    mine = view.marked(own)
    rule = FlyingRule(
        options.outline_behind_units * unit,
        options.outline_level_units * unit,
        reach=2,
        few=options.outline_few,
        margin=2,
    )
    flying = lies_behind(cell[own], depth[own], image, mine, width, rule)
    return flying, _rim(cell[rest], depth[rest], image, mine, width, rule)


@compiled
def _rim(cells: I32, depths: F32, image: F32, own: Mask, width: int, rule: FlyingRule) -> Mask:
    """Mark the pixels (M,) touching the object, at its depth or nearer, and apart from others."""
    result = np.zeros(len(cells), np.bool_)
    border = rule.margin * (width + 1)
    for i in range(len(cells)):
        others, touches, behind = 0, False, False
        if not border <= cells[i] < len(image) - 1 - border:
            continue
        for row in (-width, 0, width):
            for other in range(cells[i] + row - 1, cells[i] + row + 2):
                if other == cells[i]:
                    continue
                difference = depths[i] - image[other]
                if own[other]:
                    touches |= abs(difference) < rule.behind
                    behind |= difference > rule.behind
                else:
                    others += abs(difference) < rule.level
        result[i] = touches and not behind and others <= rule.few
    return result


@dataclass(frozen=True, slots=True, eq=False)
class Claim:
    """Points claimed by an object, with ``cost`` (M,) in metres of position and colour.

    ``gap`` (M,): distance from the model by position alone; ``nearest`` (M,): the model point.
    """

    indices: I64
    cost: F32
    gap: F64
    nearest: I64

    @staticmethod
    def nothing() -> Claim:
        """Return an empty claim."""
        none = np.empty(0, np.int64)
        return Claim(none, np.empty(0, np.float32), np.empty(0), none)

    def pick(self, which: Mask) -> Claim:
        """Return the claim restricted to some of the points."""
        return Claim(self.indices[which], self.cost[which], self.gap[which], self.nearest[which])


def claim(
    view: View, indices: I64, surface: F64, colour: F32, weight: float, reach: float
) -> Claim:
    """Return the claim on the points ``indices`` near a model's ``surface`` (M, 3) in the world.

    The cost of a point is the minimum distance in position and colour over its three nearest model
    points.  Points at ``reach`` metres or farther are not claimed.
    """
    if len(indices) == 0 or len(surface) == 0:
        return Claim.nothing()
    lo, hi = bounds(surface)
    far = 1.001 * reach  # a margin for single precision at the border
    xyz = view.xyz.take(indices, axis=0)
    close = np.flatnonzero(within(xyz, lo - far, hi + far))
    gap, near = _nearest(surface, xyz[close].astype(np.float64), reach)
    some = np.flatnonzero(near[:, 0] >= 0)
    indices, gap, near = indices[close[some]], gap[some], near[some]
    cost = _costs(gap, near, view.colour(indices), colour, weight)
    return Claim(indices, cost, gap[:, 0], near[:, 0])


@compiled
def _nearest(surface: F64, xyz: F64, reach: float) -> tuple[F64, I64]:
    """See ``nearest_three``, for the ``surface`` (M, 3)."""
    return nearest_three(columns(surface, NONE, 0.0), xyz, reach)


@compiled
def _costs(gap: F64, near: I64, tint: F32, colour: F32, weight: float) -> F32:
    """Return (M,) the minimum distance of each point in position and colour."""
    cost = np.empty(len(gap), np.float32)
    for i in range(len(gap)):
        least = np.inf
        for k in range(gap.shape[1]):
            at = near[i, k]
            if at >= 0:
                unlike = 0.0
                for a in range(3):
                    unlike += float(tint[i, a] - colour[at, a]) ** 2
                least = min(least, gap[i, k] ** 2 + weight**2 * unlike)
        cost[i] = np.sqrt(least)
    return cost


def together(one: I64, other: I64) -> I64:
    """Return the sorted union of two sorted arrays of points."""
    if not len(other):
        return one
    both = np.sort(np.concatenate([one, other]))
    return np.asarray(both[np.concatenate([[True], both[1:] != both[:-1]])])


def decide(count: int, claims: dict[int, Claim]) -> dict[int, Claim]:
    """Assign each point to the claim with the minimum cost; ties go to the first label."""
    best = np.full(count, np.inf, np.float32)
    for found in claims.values():
        best[found.indices] = np.minimum(best[found.indices], found.cost)
    taken = np.zeros(count, np.bool_)
    result: dict[int, Claim] = {}
    for label, found in claims.items():
        mine = (found.cost <= best[found.indices]) & ~taken[found.indices]
        taken[found.indices[mine]] = True
        result[label] = found.pick(mine)
    return result


def without(free: Mask, claims: Iterable[Claim]) -> Mask:
    """Return a mask of the ``free`` points (N,) outside all claims."""
    left = free.copy()
    for claimed in claims:
        left[claimed.indices] = False
    return left


def cut_off(view: View, rest: I64, unit: float, by: Mask | None = None) -> bool:
    """Return whether a nearer surface may hide a continuation of the points ``rest``.

    A surface that ends at the outline of a nearer one may continue behind it.  ``unit``: tolerance
    (m); ``by`` (cells + 1,): pixels that may occlude it, by default all.
    """
    options = view.options.claim
    if view.lens is None or not len(rest):
        return False
    cell, depth = view.cells
    width = view.lens.shape[1]
    steps = options.hiding_px * np.array([-width, -1, 1, width])
    around = np.clip(cell[rest][:, None] + steps, 0, len(view.depth) - 1)
    with np.errstate(invalid="ignore"):
        nearer = view.depth[around] < depth[rest][:, None] - options.hiding_units * unit
    if by is not None:
        nearer &= by[around]
    return float(nearer.any(axis=1).mean()) > options.hiding_share
