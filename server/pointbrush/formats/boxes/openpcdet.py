"""Boxes of OpenPCDet's custom datasets, our own export among them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pointbrush.formats.boxes.documents import lines_of_words, vector
from pointbrush.formats.boxes.figures import Box, FrameBoxes
from pointbrush.formats.boxes.rotations import euler_matrix

WORDS = 8
STEP = 1e-4
"""Metres, last digit of the numbers of our export: boxes are enlarged by it on each side."""


def read_openpcdet(path: Path) -> Iterator[FrameBoxes]:
    """Read ``labels/NAME.txt``: lines ``x y z dx dy dz heading class``, heading about z, radians.

    Raises BadInputError for another number of words, ValueError for numbers that are not finite.
    """
    boxes: list[Box] = []
    for words in lines_of_words(path, WORDS, WORDS):
        values = vector(words, range(7))
        rotation = euler_matrix(np.array([0.0, 0.0, values[6]]), "zyx")
        boxes.append(Box(words[7], "", values[:3], values[3:6] + 2 * STEP, rotation))
    yield FrameBoxes(None, tuple(boxes))
