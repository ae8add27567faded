"""Points as packed rows, the form of a large frame in temporary files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.frame import PointFrame
from pointbrush.sequences.columns import POINT_FIELDS, frame_meta, to_local
from pointbrush.sequences.octree.coordinates import scaling_of
from pointbrush.sequences.octree.order import bounds
from pointbrush.sequences.octree.partition import Groups, edge_exponent, group
from pointbrush.sequences.wire.chunk import Grid

MAX_SOURCE_POINTS = 2**32 - 1

Rows = NDArray[Any]
"""Structured: ``xyz`` in source coordinates, the point fields given, ``source_index``."""


def row_dtype(part: PointFrame) -> np.dtype[Any]:
    """The type of the rows that hold all of a part's fields."""
    layout = [
        (name, column.dtype, column.shape[1:])
        for name in ("xyz", *POINT_FIELDS)
        if (column := getattr(part, name)) is not None
    ]
    return np.dtype([*layout, ("source_index", np.dtype(np.uint32), ())])


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A part of a large frame on its way to the partition."""

    frame: PointFrame
    first: int
    exponent: int
    shift: NDArray[np.float64]

    def groups(self) -> Groups:
        """Its rows, sorted by cube."""
        dtype = row_dtype(self.frame)
        return group(self.frame, dtype, self.first, self.shift, self.exponent)


class Parts:
    """Numbers the parts of a frame and checks that they belong together."""

    def __init__(self, frames: Iterable[PointFrame], grid: Grid) -> None:
        self._frames, self._grid = frames, grid
        self.meta: dict[str, Any] = {}

    def __iter__(self) -> Iterator[Part]:
        """The parts that have points.

        Raises BadInputError when fields or types differ or there are too many points.
        """
        dtype: np.dtype[Any] | None = None
        first = exponent = 0
        for frame in self._frames:
            if len(frame) == 0:
                continue
            given = row_dtype(frame)
            if dtype is None:
                dtype, scaling = given, scaling_of(frame).tolist()
                self.meta = frame_meta(frame) | {"scaling": scaling}
                lo, hi = bounds(to_local(frame.xyz, self._grid.shift))
                exponent = edge_exponent(float((hi - lo).max()))
            if given != dtype:
                raise BadInputError(
                    f"expected every part of the frame to have {dtype.names}, got {given.names}"
                )
            if first + len(frame) > MAX_SOURCE_POINTS:
                raise BadInputError(f"expected at most {MAX_SOURCE_POINTS:,} points in a frame")
            yield Part(frame, first, exponent, self._grid.shift)
            first += len(frame)
