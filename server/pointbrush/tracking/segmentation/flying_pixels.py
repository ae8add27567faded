"""Flying pixels: what a depth camera measures between two surfaces, at the outline of the nearer.

It lies behind the thing whose outline it is, within the tolerance of its far side, and moves as
the thing does: it would be taken for surface.  But nothing beside it is as deep as it is.
"""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.geometry.compiled import compiled
from pointbrush.tracking.interface import F32, I64, Mask
from pointbrush.tracking.sensor.lens import I32
from pointbrush.tracking.sensor.view import View

BEHIND, BESIDE = 4.0, 2.0
"""Units by which it lies behind a neighbour, and within which a neighbour is as deep as it is."""
MOSTLY, FEWEST = 0.5, 20
"""Share of them that a thing was painted with, to have them ever after, and how many tell it."""


def flying(view: View, points: I64, unit: float) -> Mask:
    """Which ``points`` (M,) of a thing lie behind others of it, and none of them beside it.

    ``unit`` metres of tolerance.  None before a sensor that sees no depth images.
    """
    if view.lens is None or not view.lens.lattice or not len(points):
        return np.zeros(len(points), np.bool_)
    return _loose(view, points, view.marked(points), unit)


def painted_with_flying(view: View, points: I64, unit: float) -> bool:
    """Whether most of the flying pixels at the outline of painted ``points`` (M,) are painted too.

    Who outlines a thing in a picture paints those inside the outline as well.
    """
    if view.lens is None or not view.lens.lattice:
        return False
    cell = view.cells[0]
    near = np.flatnonzero(view.around(points)[cell])
    loose = near[_loose(view, near, np.isfinite(view.depth), unit)]
    return len(loose) >= FEWEST and float(view.marked(points)[cell[loose]].mean()) > MOSTLY


def _loose(view: View, points: I64, own: Mask, unit: float) -> Mask:
    assert view.lens is not None  # noqa: S101  (callers ask only where there is one)
    width = view.lens.shape[1]
    return _flying(*view.cells, view.depth, points, own, width, BEHIND * unit, BESIDE * unit)


@compiled
def _flying(
    cells: I32,
    depths: F32,
    image: F32,
    points: I64,
    own: Mask,
    width: int,
    behind: float,
    beside: float,
) -> Mask:
    result = np.empty(len(points), np.bool_)
    for i in range(len(points)):
        cell, depth = cells[points[i]], depths[points[i]]
        lies_behind, has_like = False, False
        for row in (-width, 0, width):
            for other in range(cell + row - 1, cell + row + 2):
                # Image borders: the pixel that the row before ends with is far from the thing.
                if other == cell or other < 0 or other >= len(image) or not own[other]:
                    continue
                away = depth - image[other]
                lies_behind |= away > behind
                has_like |= abs(away) < beside
        result[i] = lies_behind and not has_like
    return result
