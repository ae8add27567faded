"""The outline of a thing in a depth image: which pixels there show it, by their depth alone.

At an outline the camera mixes the colours of the thing and of what is behind it, and a pixel may
show the one's depth with the other's colour.  What is as deep as the thing that it touches, and
stands apart from all else there, is the thing's; what lies behind it, and is as deep as hardly
anything of it, is a flying pixel.
"""

from __future__ import annotations

import numpy as np

from pointbrush.tracking.geometry.compiled import compiled, innermost
from pointbrush.tracking.interface import F32, I64, Mask
from pointbrush.tracking.sensor.lens import I32
from pointbrush.tracking.sensor.view import View

BEHIND, LEVEL = 6.6, 4.6
"""Units by which a flying pixel lies behind the thing, and within which pixels are as deep."""
FEW = 2
"""Pixels as deep up to which hardly any are."""


def outline(view: View, own: I64, rest: I64, unit: float) -> tuple[Mask, Mask]:
    """Which of a thing's points ``own`` (M,) are flying pixels; which of the ``rest`` (N,) its rim.

    ``unit`` metres of tolerance; needs a lens.
    """
    assert view.lens is not None  # noqa: S101
    cell, depth = view.cells
    image, width = view.depth, view.lens.shape[1]
    mine = view.marked(own)
    behind, level = BEHIND * unit, LEVEL * unit
    flying = _flying(cell[own], depth[own], image, mine, width, behind, level)
    return flying, _rim(cell[rest], depth[rest], image, mine, width, behind, level)


@innermost
def _inside(cell: int, image: F32, width: int) -> bool:
    """Whether there are two rows of pixels before and behind a cell."""
    return 2 * width + 2 <= cell < len(image) - 2 * width - 3


@compiled
def _flying(
    cells: I32, depths: F32, image: F32, mine: Mask, width: int, behind: float, level: float
) -> Mask:
    result = np.zeros(len(cells), np.bool_)
    for i in range(len(cells)):
        depth, like, lies_behind = depths[i], 0, False
        if not _inside(cells[i], image, width):
            continue
        for row in range(-2, 3):
            for column in range(-2, 3):
                other = cells[i] + row * width + column
                if other == cells[i] or not mine[other]:
                    continue
                away = depth - image[other]
                like += abs(away) < level
                lies_behind |= away > behind and abs(row) < 2 and abs(column) < 2
        result[i] = lies_behind and like <= FEW
    return result


@compiled
def _rim(
    cells: I32, depths: F32, image: F32, mine: Mask, width: int, behind: float, level: float
) -> Mask:
    result = np.zeros(len(cells), np.bool_)
    for i in range(len(cells)):
        depth, others, touches, lies_behind = depths[i], 0, False, False
        if not _inside(cells[i], image, width):
            continue
        for row in (-width, 0, width):
            for other in range(cells[i] + row - 1, cells[i] + row + 2):
                if other == cells[i]:
                    continue
                away = depth - image[other]
                if mine[other]:
                    touches |= abs(away) < behind
                    lies_behind |= away > behind
                else:
                    others += abs(away) < level
        result[i] = touches and not lies_behind and others <= FEW
    return result
