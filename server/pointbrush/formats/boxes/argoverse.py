"""Cuboids of Argoverse 2: ``annotations.feather``, a row for each object and sweep."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pointbrush.formats.boxes.figures import Box, FrameBoxes
from pointbrush.formats.feather import PLACE, read_table
from pointbrush.formats.options import Limits
from pointbrush.formats.poses import of_quaternion

SIZES = ("length_m", "width_m", "height_m")
WORDS = ("category", "track_uuid")


def read_argoverse(path: Path) -> Iterator[FrameBoxes]:
    """Read cuboids in the vehicle's coordinates, as the sweeps are, by the time of their sweep.

    Raises BadInputError for another table, KeyError for one that lacks columns.
    """
    table = read_table(path, Limits(), words=WORDS)
    places = np.stack([np.asarray(table[name], np.float64) for name in PLACE], axis=1)
    sizes = np.stack([np.asarray(table[name], np.float64) for name in SIZES], axis=1)
    frames: dict[int, list[Box]] = {}
    for row, time in enumerate(table["timestamp_ns"].tolist()):
        pose = of_quaternion(f"{path.name} row {row}", places[row])
        name, key = (str(table[word][row]) for word in WORDS)
        box = Box(name, key, pose[:3, 3], sizes[row], pose[:3, :3])
        frames.setdefault(int(time), []).append(box)
    for time, boxes in sorted(frames.items()):
        yield FrameBoxes(None, tuple(boxes), time=time / 1e9)
