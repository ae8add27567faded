"""LAS 1.4 and LAZ with labels in extra dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import BinaryIO

import laspy
import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.table import Columns, Table

# Steps that sources use; coordinates on one of these grids are written exactly.
GRIDS = (1e-2, 1e-3, 1e-4)
EXTRA = ("label", "category", "instance")


def write_las(out: BinaryIO, table: Table, *, compress: bool) -> None:
    """Write columns x y z [red green blue] [intensity] label category instance.

    Category goes into the classification too where it fits (0..255); label, category and
    instance are extra dimensions.  Intensity is 16 bits in LAS: fractions 0..1 are scaled to
    65535.  ``out`` seeks; the table is read three times.
    """
    types, _ = table.opened()
    header = laspy.LasHeader(version="1.4", point_format=7 if "red" in types else 6)
    extent = _Extent.of(table)
    header.offsets, header.scales = extent.offsets, extent.steps(table)
    present = [name for name in EXTRA if name in types]
    header.add_extra_dims([laspy.ExtraBytesParams(name, np.uint16) for name in present])
    with laspy.open(out, "w", header=header, do_compress=compress, closefd=False) as writer:
        for columns in table.blocks():
            writer.write_points(_record(columns, header, extent.intensity))


def _record(
    columns: Columns, header: laspy.LasHeader, intensity: float
) -> laspy.ScaleAwarePointRecord:
    rows = laspy.ScaleAwarePointRecord.zeros(len(columns["x"]), header=header)
    rows.x, rows.y, rows.z = (np.asarray(columns[axis], np.float64) for axis in "xyz")
    if "red" in columns:
        for color in ("red", "green", "blue"):
            # 8 bits to 16: 255 becomes 65535.
            setattr(rows, color, columns[color].astype(np.uint16) * 257)
    if "intensity" in columns:
        scaled = np.rint(columns["intensity"].astype(np.float64) * intensity)
        rows.intensity = np.clip(scaled, 0, 65535).astype(np.uint16)
    for name in EXTRA:
        if name in columns:
            rows[name] = columns[name]
    if "category" in columns:
        category = columns["category"]
        rows.classification = np.where(category < 256, category, 0).astype(np.uint8)
    return rows


@dataclass(frozen=True, slots=True, eq=False)
class _Extent:
    """Bounds (3,) of all points, and the factor that makes their intensities 16 bits."""

    lo: NDArray[np.float64]
    hi: NDArray[np.float64]
    intensity: float

    @classmethod
    def of(cls, table: Table) -> _Extent:
        lo, hi = np.full(3, np.inf), np.full(3, -np.inf)
        greatest, fractions = 0.0, False
        for columns in table.blocks():
            if len(columns["x"]) == 0:
                continue
            lo = np.minimum(lo, [float(columns[axis].min()) for axis in "xyz"])
            hi = np.maximum(hi, [float(columns[axis].max()) for axis in "xyz"])
            if "intensity" in columns:
                greatest = max(greatest, float(columns["intensity"].max()))
                fractions = fractions or bool(np.any(columns["intensity"] % 1))
        if not np.isfinite(lo).all():
            lo = hi = np.zeros(3)
        return cls(lo, hi, 65535.0 if 0 < greatest <= 1 and fractions else 1.0)

    @property
    def offsets(self) -> NDArray[np.float64]:
        """Whole units below all points."""
        return np.floor(self.lo)

    def steps(self, table: Table) -> NDArray[np.float64]:
        """Per axis the coarsest usual grid that all lie on, else the finest that int32 spans."""
        fits = {(axis, step): True for axis in range(3) for step in GRIDS}
        for columns in table.blocks():
            for (axis, step), fit in fits.items():
                if fit:
                    counts = (columns["xyz"[axis]].astype(np.float64) - self.offsets[axis]) / step
                    fits[axis, step] = bool(np.all(np.abs(counts - np.rint(counts)) < 1e-4))
        span = self.hi - self.lo + 1.0
        usable = {key for key, fit in fits.items() if fit and span[key[0]] / key[1] < 2**31 - 1}
        finest = 10.0 ** np.ceil(np.log10(span / (2**31 - 2)))
        return np.array(
            [next((s for s in GRIDS if (axis, s) in usable), finest[axis]) for axis in range(3)]
        )
