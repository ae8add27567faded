"""Which points of the next frame belong to which object, decided for all objects at once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.geometry.columns import NONE, columns, nearest_three
from pointbrush.tracking.geometry.near import bounds, within
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.sensor.view import View


@dataclass(eq=False)
class Claim:
    """Points that an object would have: ``cost`` (M,) metres in place and colour.

    ``gap`` (M,) metres from the model in place alone, ``nearest`` (M,) the model point.
    """

    indices: I64
    cost: F32
    gap: F64
    nearest: I64

    @staticmethod
    def nothing() -> Claim:
        """A claim on no point."""
        none = np.empty(0, np.int64)
        return Claim(none, np.empty(0, np.float32), np.empty(0), none)

    def pick(self, which: Mask) -> Claim:
        """The claim on some of the points only."""
        return Claim(self.indices[which], self.cost[which], self.gap[which], self.nearest[which])


def claim(view: View, indices: I64, place: F64, colour: F32, weight: float, reach: float) -> Claim:
    """What a model at ``place`` (M, 3) of the world claims of the points ``indices``.

    A point's cost is the least, over its three nearest model points, of the distance in place and
    colour; ``reach`` metres away it is claimed no more.
    """
    if len(indices) == 0 or len(place) == 0:
        return Claim.nothing()
    lo, hi = bounds(place)
    far = 1.001 * reach  # single precision must not decide what is at the border
    xyz = view.xyz.take(indices, axis=0)
    close = np.flatnonzero(within(xyz, lo - far, hi + far))
    gap, near = nearest_three(columns(place, NONE, 0.0), xyz[close].astype(np.float64), reach)
    some = np.flatnonzero(near[:, 0] >= 0)
    indices, gap, near = indices[close[some]], gap[some], near[some]
    cost = _costs(gap, near, view.colour(indices), colour, weight)
    return Claim(indices, cost, gap[:, 0], near[:, 0])


@compiled
def _costs(gap: F64, near: I64, tint: F32, colour: F32, weight: float) -> F32:
    """The least of each point's distances (M,) in place and colour."""
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
    """The points of both, sorted, each once; each is sorted already."""
    if not len(other):
        return one
    both = np.sort(np.concatenate([one, other]))
    return np.asarray(both[np.concatenate([[True], both[1:] != both[:-1]])])


def decide(count: int, claims: dict[int, Claim]) -> dict[int, Claim]:
    """Each point to the label that claims it at the least cost; ties to the first label."""
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
    """Which points (N,) are ``free``, and no claim's."""
    left = free.copy()
    for claimed in claims:
        left[claimed.indices] = False
    return left


def cut_off(view: View, rest: I64, unit: float, by: Mask | None = None) -> bool:
    """Whether something nearer to the sensor hides how the points ``rest`` go on.

    What ends where the outline of something before it begins may go on behind that.  ``unit``
    metres of tolerance; ``by`` (cells + 1,): only pixels that count as nearer.
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
