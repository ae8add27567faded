"""The outline of a thing in a depth image: which pixels there show it, by their depth alone.

At an outline the camera mixes the colours of the thing and of what is behind it, and a pixel may
show the one's depth with the other's colour.  What is as deep as the thing that it touches, and
stands apart from all else there, is the thing's; what lies behind it, and is as deep as hardly
anything of it, is a flying pixel.
"""

from __future__ import annotations

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.interface import F32, I64, Mask
from pointbrush.tracking.segmentation.flying_pixels import FlyingRule, lies_behind
from pointbrush.tracking.sensor.lens import I32
from pointbrush.tracking.sensor.view import View


def outline(view: View, own: I64, rest: I64, unit: float) -> tuple[Mask, Mask]:
    """Which of a thing's points ``own`` (M,) are flying pixels; which of the ``rest`` (N,) its rim.

    ``unit`` metres of tolerance; needs a camera.
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
    """Which pixels (M,) touch the thing, as deep as it or nearer, and stand apart from all else."""
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
                away = depths[i] - image[other]
                if own[other]:
                    touches |= abs(away) < rule.behind
                    behind |= away > rule.behind
                else:
                    others += abs(away) < rule.level
        result[i] = touches and not behind and others <= rule.few
    return result
