"""Points of a frame inside imported boxes, or marked by imported labels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.figures import FrameBox, FrameBoxes, PointFigure, points_of
from pointbrush.sequences import Sequence as Recording

Floats = NDArray[np.float64]


def figures_of(
    file: str, part: FrameBoxes, recording: Recording, frame: int, up: Floats, no_ground: bool
) -> NDArray[np.int64]:
    """Return the figure (N,) of each point, -1 for none; marks have precedence over boxes."""
    boxes = [k for k, figure in enumerate(part.boxes) if isinstance(figure, FrameBox)]
    which = np.full(recording.manifest.points[frame], -1, np.int64)
    if boxes:
        solid = tuple(figure for figure in part.boxes if isinstance(figure, FrameBox))
        found = points_of(solid, _source_points(recording, frame), up, no_ground=no_ground)
        which = np.where(found >= 0, np.array(boxes)[found], -1)
    rows = recording.source_rows(frame) if recording.manifest.dropped[frame] else None
    count = len(which) + recording.manifest.dropped[frame]
    marked = np.full(count, -1, np.int64)
    for number, figure in enumerate(part.boxes):
        if isinstance(figure, PointFigure):
            if figure.total not in (0, count):
                raise BadInputError(
                    f"{file}: expected labels of the {count:,} points of frame {frame}, got "
                    f"{figure.total:,}"
                )
            if len(figure.rows) and not 0 <= figure.rows.min() <= figure.rows.max() < count:
                raise BadInputError(
                    f"{file}: expected points 0 to {count - 1} of frame {frame}, got "
                    f"{figure.rows.min()} to {figure.rows.max()}"
                )
            marked[figure.rows] = number
    of_point = marked[: len(which)] if rows is None else marked[rows]
    return np.where(of_point >= 0, of_point, which)


def _source_points(recording: Recording, frame: int) -> NDArray[np.float64]:
    """Return the points (N, 3) of a frame in source order and coordinates."""
    stored = recording[frame]
    xyz = np.empty((stored.count, 3))
    xyz[stored.source_index] = np.asarray(stored.xyz, np.float64) + recording.manifest.shift
    return xyz
