"""LAS 1.4 and LAZ with labels in extra dimensions."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any, BinaryIO

import laspy
import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
# Steps that sources use; coordinates on one of these grids are written exactly.
GRIDS = (1e-2, 1e-3, 1e-4)
EXTRA = ("label", "category", "instance")


def write_las(out: BinaryIO, columns: Mapping[str, Array], *, compress: bool) -> None:
    """Write columns x y z [red green blue] [intensity] label category instance.

    Category goes into the classification too where it fits (0..255); label, category and
    instance are extra dimensions.  Intensity is 16 bits in LAS: fractions 0..1 are scaled to
    65535.
    """
    colored = "red" in columns
    header = laspy.LasHeader(version="1.4", point_format=7 if colored else 6)
    xyz = [np.asarray(columns[axis], np.float64) for axis in "xyz"]
    header.offsets = np.array([np.floor(axis.min()) if len(axis) else 0.0 for axis in xyz])
    header.scales = np.array(
        [_step(axis, offset) for axis, offset in zip(xyz, header.offsets, strict=True)]
    )
    present = [name for name in EXTRA if name in columns]
    header.add_extra_dims([laspy.ExtraBytesParams(name, np.uint16) for name in present])
    las = laspy.LasData(header)
    las.x, las.y, las.z = xyz
    if colored:
        for color in ("red", "green", "blue"):
            # 8 bits to 16: 255 becomes 65535.
            setattr(las, color, columns[color].astype(np.uint16) * 257)
    if "intensity" in columns:
        las.intensity = _intensity(columns["intensity"])
    for name in present:
        las[name] = columns[name]
    if "category" in columns:
        category = columns["category"]
        las.classification = np.where(category < 256, category, 0).astype(np.uint8)
    # Through memory: the writer seeks back to its header.
    buffer = io.BytesIO()
    las.write(buffer, do_compress=compress)
    out.write(buffer.getbuffer())


def _step(axis: NDArray[np.float64], offset: float) -> float:
    """The coarsest usual grid that all coordinates lie on, else the finest that int32 spans."""
    span = float(np.ptp(axis)) + 1.0 if len(axis) else 1.0
    for step in GRIDS:
        counts = (axis - offset) / step
        if span / step < 2**31 - 1 and np.all(np.abs(counts - np.rint(counts)) < 1e-4):
            return step
    return float(10.0 ** np.ceil(np.log10(span / (2**31 - 2))))


def _intensity(values: Array) -> NDArray[np.uint16]:
    scale = 65535.0 if len(values) and 0 < values.max() <= 1 and np.any(values % 1) else 1.0
    return np.clip(np.rint(values.astype(np.float64) * scale), 0, 65535).astype(np.uint16)
