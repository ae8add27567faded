"""Correction of a camera's position by the borders of a mask.

Neighbouring points of one surface mostly have the same value of the mask: its borders lie where the
depth jumps.  An error of the calibration moves the borders onto the surfaces, where they divide
pairs of neighbours.  The correction is the offset that divides the fewest pairs.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pointbrush.masks.borders import border_distance, neighbours
from pointbrush.masks.options import LiftOptions
from pointbrush.masks.views import View
from pointbrush.masks.visibility import point_spacing
from pointbrush.values.masks import VOID

Pairs = tuple[NDArray[np.int64], NDArray[np.int64]]


def align(
    view: View, seen: NDArray[np.int64], mask: NDArray[np.unsignedinteger], options: LiftOptions
) -> NDArray[np.float64] | None:
    """Return the offset (3,), metres, that moves points onto their values of a mask.

    ``seen``: numbers of the points that the camera sees.  None: too few borders of the mask lie at
    jumps of depth to determine an offset.
    """
    search, values = options.align, mask.ravel()
    error = view.focal * options.metre_error / view.depth[seen] + options.pixel_error
    # Twice as far as the search moves them, so that borders never leave the points.
    near = seen[border_distance(mask)[view.pixel[seen]] <= 2 * search.widest * error]
    if not len(near):
        return None
    part = view.only(near)
    one, other = surface_pairs(part, point_spacing(view, seen), options)

    def divided(offset: NDArray[np.float64]) -> int:
        """Return the number of pairs with different values after the points move."""
        pixel = part.moved(offset).pixel
        value = np.where(pixel >= 0, values[pixel], VOID)
        # A pair without evidence counts as divided: else points would move into the holes.
        return int(((value[one] != value[other]) | (value[one] == VOID)).sum())

    unit = options.metre_error + options.pixel_error * float(np.median(part.depth)) / view.focal
    steps = np.linspace(-search.widest, search.widest, 2 * search.steps + 1) * unit
    grid = [np.array(offset) for offset in product(steps, steps, [0.0])]
    counts = [divided(offset) for offset in grid]
    saved = float(np.median(counts)) - min(counts)
    if saved < search.least_pairs:
        return None
    weight = search.prior * saved / unit**2

    def cost(offset: NDArray[np.float64]) -> float:
        return divided(offset) + weight * float(offset @ offset)

    costs = [count + weight * (offset @ offset) for count, offset in zip(counts, grid, strict=True)]
    best = descend(grid[int(np.argmin(costs))], cost, steps, search.finest * unit)
    return best if cost(best) <= (1 - search.least_gain) * cost(np.zeros(3)) else np.zeros(3)


def descend(
    best: NDArray[np.float64],
    cost: Callable[[NDArray[np.float64]], float],
    steps: NDArray[np.float64],
    finest: float,
) -> NDArray[np.float64]:
    """Return the offset (3,) of the least cost around it, in a descent from ``best``.

    The step begins with that of ``steps`` and is halved down to ``finest``, metres.  The result is
    within the range of ``steps`` along each axis.
    """
    least, step = cost(best), steps[1] - steps[0]
    while step > finest:
        moves = [best + step * np.array(sides) for sides in product((-1, 0, 1), repeat=3)]
        moves = [np.clip(move, steps[0], steps[-1]) for move in moves]
        lowest, number = min((cost(move), k) for k, move in enumerate(moves))
        if lowest < least:
            least, best = lowest, moves[number]
        else:
            step /= 2
    return best


def surface_pairs(view: View, spacing: float, options: LiftOptions) -> Pairs:
    """Return the numbers of points that are neighbours in the picture and lie on one surface.

    ``spacing``: mean distance of points, pixels.
    """
    cell = max(1, round(spacing))
    row, column = (at // cell for at in np.divmod(view.pixel, view.width))
    number = np.full((-(-view.height // cell), -(-view.width // cell)), -1, np.int64)
    number[row, column] = np.arange(len(view.pixel))
    pairs = []
    for axis in (0, 1):
        one, other = (number[side].ravel() for side in neighbours(axis))
        both = (one >= 0) & (other >= 0)
        one, other = one[both], other[both]
        depths = view.depth[one], view.depth[other]
        gap = np.minimum(*depths) * options.visibility.depth_tolerance / 2
        smooth = np.abs(depths[0] - depths[1]) <= gap
        pairs.append((one[smooth], other[smooth]))
    ones, others = zip(*pairs, strict=True)
    return np.concatenate(ones), np.concatenate(others)
