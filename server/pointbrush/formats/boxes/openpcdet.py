"""Boxes of OpenPCDet's custom datasets, our own export among them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.figures import Box, FrameBoxes
from pointbrush.formats.boxes.rotations import euler_matrix
from pointbrush.formats.options import read_bytes

WORDS = 8
STEP = 1e-4
"""Metres, last digit of the numbers of our export: boxes are enlarged by it on each side."""


def read_openpcdet(path: Path) -> Iterator[FrameBoxes]:
    """Read ``labels/NAME.txt``: lines ``x y z dx dy dz heading class``, heading about z, radians.

    Raises BadInputError for another number of words, and for numbers that are not finite.
    """
    boxes: list[Box] = []
    for number, line in enumerate(read_bytes(path).decode("utf-8", "replace").splitlines(), 1):
        words = line.split()
        if not words:
            continue
        if len(words) != WORDS:
            raise BadInputError(
                f"{path.name} line {number}: expected {WORDS} values, got {len(words)}"
            )
        values = np.array(words[:7], np.float64)
        if not np.isfinite(values).all():
            raise BadInputError(f"{path.name} line {number}: expected finite numbers")
        rotation = euler_matrix(np.array([0.0, 0.0, values[6]]), "zyx")
        boxes.append(Box(words[7], "", values[:3], values[3:6] + 2 * STEP, rotation))
    yield FrameBoxes(None, tuple(boxes))
