"""Sides of a box with a known yaw: ends of points, possible extent and likely size.

Each side lies between the outermost points and the first free space beyond them.  Space in front of
a visible side is free; occluded space is open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting.observation import Surface
from pointbrush.fitting.options import FitOptions
from pointbrush.fitting.priors import SizePrior
from pointbrush.fitting.rays import Steps, count_passing
from pointbrush.fitting.yaw import upright

Floats = NDArray[np.float64]
CERTAIN = 1e3
"""Cost, in nats, of an impossible size."""
TIED = 0.05
"""Nats; costs that differ by less are equal."""
SEEN_QUANTILE = 0.8
"""Quantile over frames of visible sizes: some frames have points painted outside."""
OPEN = 4.0
"""Maximum size with an open side, in standard deviations above the mean of a class."""
FACING = 0.5
"""Minimum cosine between the directions of a side and of the sensor for a facing side."""


@dataclass(frozen=True, slots=True, eq=False)
class Sides:
    """Sides along x, y, z of a box, in level coordinates rotated by ``yaw``.

    ``low`` and ``high`` (3,): ends of points, in metres.  For each axis, ``costs`` (n,): minimum
    cost, in nats, of growing by 0, 1, … bins beyond them; ``shares`` (n,): share of the growth
    beyond ``high``.
    """

    yaw: float
    low: Floats
    high: Floats
    costs: tuple[Floats, ...]
    shares: tuple[Floats, ...]

    @property
    def seen(self) -> Floats:
        """Visible size (3,)."""
        return np.asarray(self.high - self.low)

    def middle(self, size: Floats, step: float) -> Floats:
        """Return the centre (3,) of a box of a size (3,), grown at the minimum cost."""
        over = size - self.seen
        share = np.full(3, 0.5)
        for axis, shares in enumerate(self.shares):
            if over[axis] > 0:
                share[axis] = shares[min(round(over[axis] / step), len(shares) - 1)]
        share[2] = 1.0
        return np.asarray((self.low + self.high) / 2 + over * (share - 0.5))

    def slack(self, size: Floats) -> Floats:
        """Return the approximate uncertainty (3,) of the position of a box of a size, in metres."""
        over = np.maximum(size - self.seen, 0)
        two_ways = [float(np.abs(shares - 0.5).max(initial=0) < 0.4) for shares in self.shares]
        return np.asarray(over * two_ways)


def grown(below: Floats, above: Floats) -> tuple[Floats, Floats]:
    """Return minimum costs (n,) of growing by 0, 1, … bins in total, and shares (n,) above.

    ``below`` and ``above`` (n,): costs of each side.  The share is a mean over equal costs.
    """
    total = np.arange(len(above))
    up = total[:, None]
    down = total - up
    cost = np.where(down >= 0, above[:, None] + below[np.maximum(down, 0)], np.inf)
    best = cost.min(axis=0)
    tied = cost <= best + TIED
    share = (tied * up).sum(axis=0) / tied.sum(axis=0) / np.maximum(total, 1)
    share[0] = 0.5
    return best, share


def likely_size(
    parts: Sequence[Sides], prior: SizePrior, options: FitOptions
) -> tuple[Floats, float]:
    """Return the most likely size (3,) of an object seen in some frames, and its cost in nats.

    It contains the visible size and avoids free space as far as the class allows.
    """
    seen = np.quantile([part.seen for part in parts], SEEN_QUANTILE, axis=0)
    step, weight = options.bin_size, min(1.0, options.frames_most / len(parts))
    size, total = seen.copy(), float(np.log(prior.spread).sum() - np.log(prior.weight))
    for axis in range(3):
        mean, spread = prior.mean[axis], prior.spread[axis]
        sizes = seen[axis] + step * np.arange(max(len(part.costs[axis]) for part in parts))
        sizes = np.append(sizes, mean) if mean > seen[axis] else sizes
        cost = 0.5 * ((sizes - mean) / spread) ** 2
        for part in parts:
            bins = np.arange(len(part.costs[axis])) * step
            cost = cost + weight * np.interp(sizes - part.seen[axis], bins, part.costs[axis])
        best = int(cost.argmin())
        size[axis], total = sizes[best], total + float(cost[best])
    return size, total


def edge(values: Floats, facing: bool, options: FitOptions) -> float:
    """Return the upper end of points along an axis; for few points, the outermost one.

    Range noise spreads points on both sides of a side ``facing`` the sensor.
    """
    if len(values) < 40:
        return float(values.max())
    top = float(np.quantile(values, 1 - min(0.005, 2 / len(values))))
    if not facing:
        return top
    return float(np.quantile(values[values > top - options.edge_depth], options.edge_quantile))


@dataclass(frozen=True, slots=True, eq=False)
class _Space:
    """Space around an object for passing rays, in coordinates rotated by the yaw of its box.

    ``eyes`` and ``ends`` (m, 3): rays; ``low`` and ``high`` (3,): the object with its usual size;
    ``floor``: height of the ground, in metres; ``height``: usual height of the class, in metres.
    """

    eyes: Floats
    ends: Floats
    low: Floats
    high: Floats
    floor: float
    height: float

    def beside(self, share: float, options: FitOptions) -> tuple[Floats, Floats]:
        """Return the bounds (3,), (3,) of the middle ``share`` of the sides, up to the windows."""
        middle, half = (self.low + self.high) / 2, (self.high - self.low) / 2 * share
        low, high = middle - half, middle + half
        low[2], high[2] = (self.floor + part * self.height for part in options.band)
        return low, high


def find_sides(surface: Surface, yaw: float, prior: SizePrior, options: FitOptions) -> Sides:
    """Return the sides of a surface for a ``yaw``.

    Without rays, sides are at the ends of the points.
    """
    R = upright(yaw)
    points, eyes, ends = surface.xyz @ R, surface.eyes @ R, surface.ends @ R
    mean, spread = np.array(prior.mean), np.array(prior.spread)
    lowest = float(points[:, 2].min())
    floor = lowest if surface.ground is None else min(surface.ground, lowest + 0.1)
    toward = np.zeros(3)
    if len(ends) and not prior.person:
        toward = eyes.mean(axis=0) - np.median(points, axis=0)
        toward[:2] /= max(float(np.linalg.norm(toward[:2])), 1e-9)
        toward[2] = 0
    body = points[points[:, 2] > floor + options.clearance]
    body = body if len(body) >= options.least_points else points
    low = np.array([-edge(-body[:, a], toward[a] < -FACING, options) for a in range(3)])
    high = np.array([edge(body[:, a], toward[a] > FACING, options) for a in range(3)])
    margin = options.person_margin if prior.person else options.margin
    low, high = low - margin, high + margin
    low[2] = floor
    wide = _grown(low, high, eyes.mean(axis=0) if len(ends) else None, mean)
    space = _Space(eyes, ends, *wide, floor, float(mean[2]))
    costs, shares = [], []
    for axis, reach in enumerate(np.maximum(mean + OPEN * spread - (high - low), 0)):
        count = int(np.ceil(reach / options.bin_size)) + 1
        below = _into_free(space, axis, -1.0, float(low[axis]), count, options)
        above = _into_free(space, axis, 1.0, float(high[axis]), count, options)
        if axis == 2:  # the bottom is on the ground
            below = np.where(np.arange(count) > 0, CERTAIN, 0.0)
        cost, share = grown(below, above)
        costs.append(cost)
        shares.append(share)
    return Sides(yaw, low, high, tuple(costs), tuple(shares))


def _into_free(
    space: _Space, axis: int, sign: float, side: float, count: int, options: FitOptions
) -> Floats:
    """Return the costs (count,), in nats, of growing beyond a side by 0, 1, … bins.

    They count passing rays through the middle of the growth and near its corners.
    """
    cost = np.zeros(count)
    if not len(space.ends) or count < 2:
        return cost
    rounded = round(options.corner / options.bin_size)
    for inner, shift in ((options.inner, 0), (options.outer, rounded)):
        steps = Steps(axis, sign, side, options.bin_size, count - 1)
        passing = count_passing(space.eyes, space.ends, steps, *space.beside(inner, options))
        rays = np.clip(passing - options.rays_spare, 0, options.rays_most)
        rays = np.maximum.accumulate(rays)
        nats = options.ray_cost * rays[: max(count - 1 - shift, 0)]
        cost[count - len(nats) :] = np.maximum(cost[count - len(nats) :], nats)
    return cost


def _grown(low: Floats, high: Floats, eye: Floats | None, mean: Floats) -> tuple[Floats, Floats]:
    """Return the visible bounds grown away from the eye to the mean size of the class."""
    lower, higher = low.copy(), high.copy()
    for axis in range(2):
        more = max(float(mean[axis] - (high - low)[axis]), 0.0)
        if eye is not None and eye[axis] > high[axis]:
            lower[axis] -= more
        elif eye is not None and eye[axis] < low[axis]:
            higher[axis] += more
        else:
            lower[axis] -= more / 2
            higher[axis] += more / 2
    higher[2] = max(high[2], low[2] + 0.8 * mean[2])
    return lower, higher
