"""Placement of the points of an export: float32 near the origin, in the axes of loaders."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.writers.labeled import ExportFrame

Matrix = NDArray[np.float64]
FAR = 8192.0
"""Metres from the origin beyond which the step of a float32 exceeds a millimetre."""


def shift_of(frame: ExportFrame) -> Matrix:
    """Choose whole metres to subtract from all frames: (3,), zero unless points are far away."""
    farthest, total = 0.0, np.zeros(3)
    for block in frame.blocks():
        xyz = block.points.xyz
        if xyz.dtype == np.float32:
            return np.zeros(3)
        farthest = max(farthest, float(np.abs(xyz).max(initial=0.0)))
        total += xyz.sum(axis=0)
    return np.zeros(3) if farthest < FAR else np.floor(total / frame.count)


def placement_of(frame: ExportFrame, R_export_source: Matrix) -> Matrix:
    """Make ``T_export_source`` (4, 4): shift far points to the origin, then turn the axes."""
    T_export_source = np.eye(4)
    T_export_source[:3, :3] = R_export_source
    T_export_source[:3, 3] = -R_export_source @ shift_of(frame)
    return T_export_source


def placed(T_export_source: Matrix, xyz: NDArray[np.floating]) -> Matrix:
    """Move points (N, 3) from source to export coordinates, as float64."""
    moved = xyz.astype(np.float64) @ T_export_source[:3, :3].T + T_export_source[:3, 3]
    return np.asarray(moved, np.float64)
