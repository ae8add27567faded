"""The pixel lattice of a depth camera, and the interlaced levels that its images are sent in.

A lattice defines the ray of each pixel, so that a point is a pixel and a depth.  Levels are
lattices, too: level 0 holds every ``2**k``-th row and column, and each further one halves the
distance between columns, then that between rows, so that a prefix of levels is a smaller image.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from pointbrush.sequences.octree.order import LEVEL0_POINTS

DEPTH_FORMAT = 2
"""Version of depth images' bytes (``codec``); recordings of an older one are sent as points."""
STRIP = 16
"""Rows of a strip: points of a level are numbered strip by strip, column by column within one."""
CHUNK_PIXELS = 65536
"""Most pixels of a chunk; a level of more is cut into bands of strips."""
FARTHEST = 65535
"""Greatest depth, in units."""
GRID_CELLS = 65535
"""Cells of the grid, along each side of a recording's box, that a page may round points to; along
the camera's axis it need not."""
GRID_ROUNDING = 0.51
"""Greatest shift of a point along a side by this rounding, in cells: half a cell, and the error of
single precision."""


class Band(NamedTuple):
    """The pixels of a chunk: the rows of ``level`` from ``row`` to before ``stop``.

    ``down`` and ``across`` are the steps from row to row and column to column, ``half`` the
    distance to the known neighbours, 0 in level 0; ``vertical``: they are above and below.
    ``step``: the step of the lattice that is complete after the level.
    """

    level: int
    row: int
    stop: int
    column: int
    down: int
    across: int
    half: int
    vertical: bool
    step: int


@dataclass(frozen=True)
class Lattice:
    """Pixels of ``width`` by ``height`` seen from ``eye`` (3,), local metres.

    The point of a pixel at ``depth`` units lies ``unit * depth`` metres along ``sign`` times axis
    ``axis`` from there, and ``tangent[i] + pitch[i] * pixel[i]`` times as far along the other two
    axes, in their order: the first goes with columns, the second with rows.
    """

    width: int
    height: int
    axis: int
    sign: float
    tangent: tuple[float, float]
    pitch: tuple[float, float]
    eye: tuple[float, float, float]
    unit: float

    @property
    def sides(self) -> tuple[int, int]:
        """The axes along which column and row numbers increase."""
        across, down = (axis for axis in range(3) if axis != self.axis)
        return across, down

    @cached_property
    def first_step(self) -> int:
        """Distance between the pixels of level 0."""
        step = 1
        while -(-self.width // step) * -(-self.height // step) > LEVEL0_POINTS:
            step *= 2
        return step

    @cached_property
    def bands(self) -> tuple[Band, ...]:
        """The chunks that a frame of all pixels has, in their order."""
        return tuple(self._bands())

    def _bands(self) -> Iterator[Band]:
        step = self.first_step
        yield from self._cut(Band(0, 0, 0, 0, step, step, 0, False, step))
        level = 1
        while step > 1:
            half = step // 2
            yield from self._cut(Band(level, 0, 0, half, step, step, half, False, half))
            yield from self._cut(Band(level + 1, half, 0, 0, step, half, half, True, half))
            level, step = level + 2, half

    def _cut(self, level: Band) -> Iterator[Band]:
        """Yield the bands of a whole level, none if it has no pixel; its ``stop`` is ignored."""
        rows = -(-(self.height - level.row) // level.down)
        columns = -(-(self.width - level.column) // level.across)
        if rows <= 0 or columns <= 0:
            return
        strips = -(-rows // STRIP)
        parts = -(-rows * columns // CHUNK_PIXELS)
        for part in range(parts):
            first, stop = (
                level.row + strips * p // parts * STRIP * level.down for p in (part, part + 1)
            )
            yield level._replace(row=first, stop=min(stop, self.height))

    def picture_step(self, band: Band) -> int:
        """Distance between the pixels of the picture that a band's colours are in: 1, 2, 8, 32 …

        The steps keep the bytes of repeated pixels few; the first level has a small picture.
        """
        step = 1
        while (finer := 2 if step == 1 else 4 * step) <= band.step:
            step = finer
        return step

    def carries_picture(self, chunk: int) -> bool:
        """Return whether a chunk carries a picture: it is the first one with colours in it."""
        if chunk == 0:
            return True
        before, band = self.bands[chunk - 1 : chunk + 1]
        return self.picture_step(before) != self.picture_step(band)


def lattice_of(given: dict[str, Any] | None) -> Lattice | None:
    """Return a lattice of its JSON, which has lists in place of tuples."""
    if given is None:
        return None
    plain: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in given.items()
    }
    return Lattice(**plain)
