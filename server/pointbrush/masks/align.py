"""Correction of a camera's position by the borders of a mask.

On one surface, neighbouring points mostly have one value of the mask: its borders lie where the
depth jumps.  An error of the calibration moves the borders onto the surfaces.  The offset that
divides the fewest pairs of neighbours is the correction.
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

    None: the mask has too few borders at jumps of depth to determine it.
    ``seen``: numbers of the points that the camera sees.
    """
    search, values = options.align, mask.ravel()
    error = view.focal * options.metre_error / view.depth[seen] + options.pixel_error
    # Twice as far as the search moves them, so that borders never leave the points.
    near = seen[border_distance(mask)[view.pixel[seen]] <= 2 * search.widest * error]
    if not len(near):
        return None
    part = view.only(near)
    one, other = surface_pairs(part, point_spacing(view, seen), options)

    def cost(offset: NDArray[np.float64]) -> float:
        pixel = part.moved(offset).pixel
        found = np.where(pixel >= 0, values[pixel], VOID)
        # A pair without evidence counts as divided: else points would move into the holes.
        divided = (found[one] != found[other]) | (found[one] == VOID)
        return float(divided.sum() + weight * (offset @ offset))

    weight = 0.0
    unit = options.metre_error + options.pixel_error * float(np.median(part.depth)) / view.focal
    steps = np.linspace(-search.widest, search.widest, 2 * search.steps + 1) * unit
    grid = [np.array(offset) for offset in product(steps, steps, [0.0])]
    costs = [cost(offset) for offset in grid]
    gained = float(np.median(costs)) - min(costs)
    if gained < search.least_pairs:
        return None
    weight = search.prior * gained / unit**2
    best = refined(min(grid, key=cost), cost, steps, search.finest * unit)
    return best if cost(best) <= (1 - search.least_gain) * cost(np.zeros(3)) else np.zeros(3)


def refined(
    best: NDArray[np.float64],
    cost: Callable[[NDArray[np.float64]], float],
    steps: NDArray[np.float64],
    finest: float,
) -> NDArray[np.float64]:
    """Return the offset (3,) of the least cost near ``best``, within the range of ``steps``."""
    least, step = cost(best), steps[1] - steps[0]
    while step > finest:
        moves = [best + step * np.array(sides) for sides in product((-1, 0, 1), repeat=3)]
        moves = [np.clip(move, steps[0], steps[-1]) for move in moves]
        found = min((cost(move), k) for k, move in enumerate(moves))
        if found[0] < least:
            least, best = found[0], moves[found[1]]
        else:
            step /= 2
    return best


def surface_pairs(view: View, spacing: float, options: LiftOptions) -> Pairs:
    """Return pairs of neighbours in the picture that lie on one surface."""
    cell = max(1, round(spacing))
    row, column = (place // cell for place in np.divmod(view.pixel, view.width))
    number = np.full((-(-view.height // cell), -(-view.width // cell)), -1, np.int64)
    number[row, column] = np.arange(len(view.pixel))
    found = []
    for axis in (0, 1):
        one, other = (number[side].ravel() for side in neighbours(axis))
        both = (one >= 0) & (other >= 0)
        one, other = one[both], other[both]
        depths = view.depth[one], view.depth[other]
        gap = np.minimum(*depths) * options.visibility.depth_tolerance / 2
        smooth = np.abs(depths[0] - depths[1]) <= gap
        found.append((one[smooth], other[smooth]))
    return np.concatenate([pair[0] for pair in found]), np.concatenate([pair[1] for pair in found])
