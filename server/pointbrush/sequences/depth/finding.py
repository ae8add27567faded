"""Finding the pixel lattice of a recording in its first frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import PointFrame
from pointbrush.sequences.depth.lattice import Lattice
from pointbrush.sequences.depth.projection import find
from pointbrush.tracking.interface import ArrayFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import Lens, find_lens

MILLIMETRE = 0.001
WHOLE = 0.02
"""Greatest difference of depths from whole millimetres, for cameras that measure in them."""
FIT_SHARE = 1 / 8
"""Greatest distance of a point from its pixel's ray, as a share of the grid's step."""
MARGIN_SHARE = 1 / 32
"""Margin for later frames beyond the first one's edges, as a share of the image."""


def find_lattice(
    frame: PointFrame, xyz: NDArray[np.float32], shift: NDArray[np.float64], step: float
) -> Lattice | None:
    """The lattice that a frame's points ``xyz`` (N, 3), local metres, lie on; None without one.

    A depth image defines it; otherwise it is searched from the sensor's place, or the origin.
    ``step``: the recording's grid, metres, which is the unit of depths if the camera does not
    measure whole millimetres.
    """
    if frame.intensity is not None:  # a picture holds three values a pixel
        return None
    viewpoint = None if frame.viewpoint is None else frame.viewpoint - shift
    options = TrackerOptions()
    # All points: a regular sample of an image may contain only some of its columns.
    options = replace(options, lens=replace(options.lens, sampled_points=len(xyz)))
    lens = find_lens(ArrayFrame(xyz, viewpoint), options=options)
    if lens is None or not lens.lattice:
        return None
    lattice = _fitted(lens, xyz, step)
    if lattice is None or frame.camera is None or frame.pixel is None:
        return lattice
    return _whole(lattice, frame, xyz)


def _fitted(lens: Lens, xyz: NDArray[np.float32], step: float) -> Lattice | None:
    """The lattice by all points, where they lie on it."""
    local = xyz.astype(np.float64) - lens.eye
    along = lens.sign * local[:, lens.axis]
    if along.min() <= 0:
        return None
    tangent, pitch, size = [], [], []
    for side, least, roughly in zip(
        [axis for axis in range(3) if axis != lens.axis], lens.least, lens.pitch, strict=True
    ):
        values = local[:, side] / along
        pixel = np.rint((values - least) / roughly)
        slope, start = _line(pixel, values)
        if np.abs((start + slope * pixel - values) * along).max() > FIT_SHARE * step:
            return None
        count = int(np.ptp(pixel)) + 1
        margin = int(MARGIN_SHARE * count) + 1
        tangent.append(float(start + slope * (pixel.min() - margin)))
        pitch.append(float(slope))
        size.append(count + 2 * margin)
    x, y, z = (float(value) for value in lens.eye)
    millimetres = along / MILLIMETRE
    counted = bool((np.abs(millimetres - np.rint(millimetres)) < WHOLE).all())
    return Lattice(
        width=size[0],
        height=size[1],
        axis=lens.axis,
        sign=lens.sign,
        tangent=(tangent[0], tangent[1]),
        pitch=(pitch[0], pitch[1]),
        eye=(x, y, z),
        unit=MILLIMETRE if counted else step,
    )


def _line(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float]:
    """Slope and start of the line nearest to points (N,) by least squares."""
    middle = x.mean()
    offset = x - middle
    spread = float(offset @ offset)
    slope = float(offset @ y) / spread if spread else 0.0
    return slope, float(y.mean()) - slope * float(middle)


def _whole(lattice: Lattice, frame: PointFrame, xyz: NDArray[np.float32]) -> Lattice:
    """The same lattice with all pixels of the frame's depth image, where it is the image's."""
    camera, pixel, found = frame.camera, frame.pixel, find(lattice, xyz)
    if camera is None or pixel is None or found is None:
        return lattice
    columns = found.pixel % lattice.width - pixel % camera.width
    rows = found.pixel // lattice.width - pixel // camera.width
    if np.ptp(columns) or np.ptp(rows):
        return lattice
    start = (
        lattice.tangent[0] + lattice.pitch[0] * int(columns[0]),
        lattice.tangent[1] + lattice.pitch[1] * int(rows[0]),
    )
    return replace(lattice, width=camera.width, height=camera.height, tangent=start)
