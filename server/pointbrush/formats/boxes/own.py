"""Boxes of our own export."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pointbrush.formats.boxes.documents import document, vector
from pointbrush.formats.boxes.figures import FrameBox, FrameBoxes

MARGIN = 1e-6
"""Metres beyond the faces of our boxes, because their outermost points lie on the faces."""


def read_own(path: Path) -> Iterator[FrameBoxes]:
    """Read ``boxes.json`` of our export: the tightest box of each label in each frame."""
    frames: dict[int, list[FrameBox]] = {}
    for entry in document(path)["boxes"]:
        box, label = entry["box"], int(entry["label"])
        center, size = vector(box["center"], range(3)), vector(box["size"], range(3))
        rotation = np.array(box["rotation"], float).reshape(3, 3)
        made = FrameBox(str(entry["name"]), "", center, size, rotation, label, margin=MARGIN)
        frames.setdefault(int(entry["frame"]), []).append(made)
    yield from (FrameBoxes(frame, tuple(boxes)) for frame, boxes in sorted(frames.items()))
