"""Points that a doubt asks about: the object tool's piece at a place, of one predicted class."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.features import Described, ExampleFrame
from pointbrush.classify.options import DoubtOptions
from pointbrush.selection.objects.options import ObjectOptions
from pointbrush.selection.objects.preparing import part_frame
from pointbrush.selection.objects.state import ObjectFrame

Numbers = NDArray[np.int64]


def piece_around(
    place: Described, cell: int, open_: NDArray[np.bool_],
    points: Callable[[Numbers], ExampleFrame], options: DoubtOptions,
) -> Numbers:  # fmt: skip
    """Return the numbers (n,) of the points of the piece round a cell, or of the nearest large one.

    A large piece has ``options.fewest`` points; n is 0 if there is none.  ``open_`` (C,): cells
    that the piece may take; ``points`` returns points by their numbers.
    """
    distance = np.linalg.norm(place.center - place.center[cell], axis=1)
    near = np.flatnonzero((distance <= options.reach * place.size)[place.of_point])
    of_point = place.of_point[near]
    frame = points(near)
    piece = _pieces(frame, place.center[cell].astype(np.float64), place.size, options)
    piece[~open_[of_point]] = -1
    large = (piece >= 0) & (np.bincount(piece + 1)[piece + 1] >= options.fewest)
    if not large.any():
        return near[:0]
    distance = np.linalg.norm(frame.xyz - place.center[cell], axis=1)
    distance[of_point != cell] += options.reach * place.size  # the cell's own points first
    own = piece[np.where(large, distance, np.inf).argmin()]
    return np.asarray(near[piece == own])


def _pieces(
    frame: ExampleFrame, middle: NDArray[np.float64], size: float, options: DoubtOptions
) -> NDArray[np.int64]:
    """Return the object tool's piece (n,) of each point, -1 for none."""
    # The tool's reaches are metres; scans of many views may be of any density.
    factor = options.scaled / size if frame.sensor == "room" else 1.0
    eye = None if frame.viewpoint is None else (frame.viewpoint - middle) * factor
    xyz = ((frame.xyz - middle) * factor).astype(np.float32)
    strength = None if frame.intensity is None else np.asarray(frame.intensity, np.float32)
    parts = part_frame(ObjectFrame(xyz, frame.rgb, strength, eye, frame.sensor), ObjectOptions())
    piece = np.append(parts.piece, -1)
    return np.asarray(piece[parts.of_point], np.int64)
