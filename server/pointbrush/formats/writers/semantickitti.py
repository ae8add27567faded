"""SemanticKITTI (Behley et al. 2019): velodyne ``.bin``, ``.label``, poses and times.

A ``.label`` entry is a uint32: the class in the lower 16 bits, with SemanticKITTI's own number if
the category has one, and the instance in the upper 16.  Points that still have the class of their
source keep its instance too.  ``.bin`` and ``.label`` have the same points, without deleted ones.

``.bin`` holds float32: coordinates far from the origin (UTM) would lose centimetres, so that they
are written relative to a shift, which the poses undo.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.readers.kitti import pack_label
from pointbrush.formats.tables.datasets import SEMANTIC_KITTI
from pointbrush.formats.writers.labeled import (
    DatasetNumbers,
    ExportFrame,
    LabeledFrame,
    Palette,
)
from pointbrush.formats.writers.output import Output
from pointbrush.formats.writers.placement import shift_of
from pointbrush.formats.writers.points import write_palette

IMPORTED = 3
"""Provenance of a point with an imported label."""
ROOT = "sequences/00"


def write_semantickitti(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """``sequences/00/velodyne/NNNNNN.bin`` and ``labels/NNNNNN.label``, palette at the top."""
    poses: list[NDArray[np.float64] | None] = []
    times: list[float | None] = []
    shift: NDArray[np.float64] | None = None
    numbers = palette.of_dataset(SEMANTIC_KITTI.name)
    for frame in frames:
        if shift is None and frame.kept:
            shift = shift_of(frame)
        with (
            output.file(f"{ROOT}/velodyne/{frame.stem}.bin") as points,
            output.file(f"{ROOT}/labels/{frame.stem}.label") as labels,
        ):
            for block in frame.blocks():
                points.write(_records(block, shift).tobytes())
                labels.write(_packed(block, numbers).tobytes())
        poses.append(block.points.pose)
        times.append(block.points.timestamp)
    if any(pose is not None for pose in poses) or (shift is not None and shift.any()):
        _write_lines("poses.txt", _pose_lines(poses, shift), output)
        # The poses are of the sensor: camera and velodyne frames coincide.
        with output.file(f"{ROOT}/calib.txt") as file:
            file.write(b"Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n")
    _write_lines("times.txt", [None if time is None else [time] for time in times], output)
    write_palette(palette, output)


def _packed(block: LabeledFrame, numbers: DatasetNumbers) -> NDArray[np.uint32]:
    """Class and instance (N,) of the points kept."""
    keep = block.keep
    label = block.label[keep]
    instance = numbers.instance[label]
    if block.points.instance is not None:
        came = numbers.plain[label] & (block.provenance[keep] == IMPORTED)
        instance = np.where(came, block.points.instance[keep], instance).astype(np.uint16)
    return pack_label(numbers.category[label], instance)


def _records(block: LabeledFrame, shift: NDArray[np.float64] | None) -> NDArray[np.float32]:
    """x y z intensity (N, 4) of the points kept."""
    keep = block.keep
    records = np.zeros((len(keep), 4), "<f4")
    records[:, :3] = block.points.xyz[keep] - (0.0 if shift is None else shift)
    if block.points.intensity is not None:
        records[:, 3] = block.points.intensity[keep]
    return records


def _pose_lines(
    poses: list[NDArray[np.float64] | None], shift: NDArray[np.float64] | None
) -> list[NDArray[np.float64] | None]:
    """The poses of points that were written relative to ``shift``, twelve numbers each.

    They are NaN for a frame without a pose among others.
    """
    T_frame_shifted = np.eye(4)
    if shift is not None:
        T_frame_shifted[:3, 3] = shift
    absent = np.full((4, 4), np.nan) if any(pose is not None for pose in poses) else np.eye(4)
    return [((absent if pose is None else pose) @ T_frame_shifted)[:3].ravel() for pose in poses]


def _write_lines(
    name: str, rows: list[NDArray[np.float64] | None] | list[list[float] | None], output: Output
) -> None:
    """One line per frame, if every frame has one."""
    lines = [" ".join(f"{value:.17g}" for value in row) for row in rows if row is not None]
    if lines and len(lines) == len(rows):
        with output.file(f"{ROOT}/{name}") as file:
            file.write(("\n".join(lines) + "\n").encode())
