"""Boxes of OpenPCDet's custom datasets, including our own export."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from pointbrush.formats.boxes.conventions import box_by, numbers_by
from pointbrush.formats.boxes.documents import lines_of_words, vector
from pointbrush.formats.boxes.figures import FrameBox, FrameBoxes

WORDS = 8
STEP = 1e-4
"""Metres, last digit of the numbers of our export."""


def read_openpcdet(path: Path) -> Iterator[FrameBoxes]:
    """Read ``labels/NAME.txt``: lines ``x y z dx dy dz heading class``, heading about z, radians.

    Raises BadInputError for another number of words, ValueError for numbers that are not finite.
    """
    boxes: list[FrameBox] = []
    for words in lines_of_words(path, WORDS, WORDS):
        values = vector(words, range(7))
        parts = values[:3], values[3:6], values[6:]
        boxes.append(replace(box_by("openpcdet", words[7], "", *parts), margin=STEP))
    yield FrameBoxes(None, tuple(boxes))


def box_line(box: FrameBox) -> str:
    """Write a box as a line of ``labels/NAME.txt``, without its end."""
    place, size, turn = numbers_by("openpcdet", box)
    numbers = " ".join(f"{value:.4f}" for value in (*place, *size, *turn))
    return f"{numbers} {'_'.join(box.name.split())}"
