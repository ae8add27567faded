"""Formats with one file of points per frame: PLY, NPZ, PCD, LAS, LAZ and CSV."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.exports.labeled import LabeledFrame, Palette, point_columns
from pointbrush.formats.exports.output import Output
from pointbrush.formats.las_write import write_las
from pointbrush.formats.npy import write_npz
from pointbrush.formats.pcd import write_pcd
from pointbrush.formats.ply import write_ply
from pointbrush.formats.text import write_csv

Columns = Mapping[str, NDArray[Any]]
PALETTE = "palette.json"


def write_palette(palette: Palette, output: Output) -> None:
    """The palette as JSON beside the frames."""
    with output.file(PALETTE) as file:
        file.write(palette.json())


def _write(
    ending: str,
    write: Callable[[BinaryIO, Columns], None],
    frames: Iterable[LabeledFrame],
    palette: Palette,
    output: Output,
) -> None:
    for frame in frames:
        with output.file(f"{frame.stem}{ending}") as file:
            write(file, point_columns(frame, palette, frame.keep))
    write_palette(palette, output)


def _write_pcd(out: BinaryIO, columns: Columns) -> None:
    """PCD packs colours; label, category and instance are fields of their own."""
    packed = dict(columns)
    if "red" in packed:
        parts = [packed.pop(color).astype(np.uint32) for color in ("red", "green", "blue")]
        packed["rgba"] = np.uint32(0xFF000000) | parts[0] << 16 | parts[1] << 8 | parts[2]
    order = sorted(packed, key=lambda name: (name not in "xyz", name != "rgba"))
    write_pcd(out, {name: packed[name] for name in order})


write_plys = partial(_write, ".ply", write_ply)
write_pcds = partial(_write, ".pcd", _write_pcd)
write_csvs = partial(_write, ".csv", write_csv)
write_lass = partial(_write, ".las", partial(write_las, compress=False))
write_lazs = partial(_write, ".laz", partial(write_las, compress=True))


def write_npzs(frames: Iterable[LabeledFrame], palette: Palette, output: Output) -> None:
    """Per frame: xyz, rgb, intensity, label, category, instance, provenance of the points kept.

    ``deleted`` is a mask over all source points: the others are the ones the arrays hold.
    """
    for frame in frames:
        keep, points, label = frame.keep, frame.points, frame.label[frame.keep]
        arrays: dict[str, NDArray[Any]] = {"xyz": points.xyz[keep]}
        if points.rgb is not None:
            arrays["rgb"] = points.rgb[keep]
        if points.intensity is not None:
            arrays["intensity"] = points.intensity[keep]
        arrays["label"] = label
        arrays["category"] = palette.category(label)
        arrays["instance"] = palette.instance(label)
        arrays["provenance"] = frame.provenance[keep]
        arrays["deleted"] = frame.deleted
        if points.pose is not None:
            arrays["pose"] = points.pose
        if points.timestamp is not None:
            arrays["timestamp"] = np.array(points.timestamp, np.float64)
        with output.file(f"{frame.stem}.npz") as file:
            write_npz(file, arrays)
    write_palette(palette, output)
