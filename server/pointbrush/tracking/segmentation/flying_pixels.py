"""Flying pixels: what a depth camera measures between two surfaces, at the outline of the nearer.

It lies behind the thing whose outline it is, within the tolerance of its far side, and moves as
the thing does: it would be taken for surface.  But nothing beside it is as deep as it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.interface import F32, I64, Mask
from pointbrush.tracking.sensor.lens import I32
from pointbrush.tracking.sensor.view import View


class FlyingRule(NamedTuple):
    """What makes a pixel a flying one: it lies ``behind`` metres behind one that it touches.

    And up to a ``few`` pixels of the thing, ``reach`` pixels around, are within ``level`` metres as
    deep.  None of the ``margin`` rows at the edge of the picture is.
    """

    behind: float
    level: float
    reach: int
    few: int
    margin: int


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
        options.behind_units * unit,
        options.level_units * unit,
        reach=1,
        few=0,
        margin=0,
    )
    return lies_behind(cell, depth, view.depth, own, view.camera.shape[1], rule)


@compiled
def lies_behind(
    cells: I32, depths: F32, image: F32, own: Mask, width: int, rule: FlyingRule
) -> Mask:
    """Which pixels (M,) are flying: behind a pixel of the thing, and as deep as hardly any of it.

    ``own`` (cells + 1,) the pixels of the thing in the depth ``image``, rows of ``width``.
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
                # Image borders: the pixel that the row before ends with is far from the thing.
                if other == cell or other < 0 or other >= len(image) or not own[other]:
                    continue
                away = depths[i] - image[other]
                like += abs(away) < rule.level
                behind |= away > rule.behind and abs(row) < 2 and abs(column) < 2
        result[i] = behind and like <= rule.few
    return result
