"""Formats with one file of points per frame: PLY, NPZ, PCD, LAS, LAZ, CSV; or a PLY per label."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from functools import partial
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.readers.las_header import is_las
from pointbrush.formats.readers.npy import KNOWN_ARRAYS, write_npz
from pointbrush.formats.readers.pcd import write_pcd
from pointbrush.formats.readers.ply import write_ply
from pointbrush.formats.readers.text import write_csv
from pointbrush.formats.tables.datasets import LAS
from pointbrush.formats.tables.table import Columns, Spools, Table
from pointbrush.formats.writers.about import ROW
from pointbrush.formats.writers.labeled import (
    ExportFrame,
    LabeledFrame,
    Palette,
    PaletteEntry,
    other_columns,
    point_columns,
    point_table,
)
from pointbrush.formats.writers.output import Output

PALETTE = "palette.json"
WIDE = ("label", "category", "instance")
"""Fields of a PCD that are unsigned integers of 4 bytes."""


def write_palette(palette: Palette, output: Output) -> None:
    """The palette as JSON beside the frames."""
    with output.file(PALETTE) as file:
        file.write(palette.json())


def _write(
    ending: str,
    write: Callable[[BinaryIO, Table], None],
    frames: Iterable[ExportFrame],
    palette: Palette,
    output: Output,
) -> None:
    for frame in frames:
        with output.file(f"{frame.stem}{ending}") as file:
            write(file, point_table(frame, palette))
    write_palette(palette, output)


def _write_pcd(out: BinaryIO, table: Table) -> None:
    """Write a PCD with packed colours and separate fields for label, category and instance."""
    write_pcd(out, Table(table.count, lambda: map(_packed, table.blocks())))


def _packed(columns: Columns) -> Columns:
    packed = dict(columns)
    if "red" in packed:
        parts = [packed.pop(color).astype(np.uint32) for color in ("red", "green", "blue")]
        packed["rgba"] = np.uint32(0xFF000000) | parts[0] << 16 | parts[1] << 8 | parts[2]
    # PCL's point types read only labels of 4 bytes.
    packed |= {name: packed[name].astype(np.uint32) for name in WIDE if name in packed}
    order = sorted(packed, key=lambda name: (name not in "xyz", name != "rgba"))
    return {name: packed[name] for name in order}


write_plys = partial(_write, ".ply", write_ply)
write_pcds = partial(_write, ".pcd", _write_pcd)
write_csvs = partial(_write, ".csv", write_csv)


def _write_las(
    compress: bool, frames: Iterable[ExportFrame], palette: Palette, output: Output
) -> None:
    """Write LAS or LAZ; points from such a file keep its header, records and fields."""
    from pointbrush.formats.writers.las import write_las, write_las_like

    classes = palette.of_dataset(LAS.name).category
    for frame in frames:
        with output.file(f"{frame.stem}{'.laz' if compress else '.las'}") as file:
            if frame.header is not None and is_las(frame.header):
                table = point_table(frame, palette, stored=True)
                write_las_like(file, table, frame.header, compress=compress)
            else:
                write_las(file, point_table(frame, palette), classes, compress=compress)
    write_palette(palette, output)


write_lass = partial(_write_las, False)
write_lazs = partial(_write_las, True)


def write_npzs(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """Per frame: xyz, rgb, intensity, label, category, instance, provenance of the points kept.

    The source's further fields are arrays beside them.  ``deleted`` is a mask over all source
    points; the arrays hold the other points.
    """
    for frame in frames:
        with ExitStack() as stack:
            columns = Spools(stack)
            for block in frame.blocks():
                columns.add(_arrays(block, palette))
            arrays: dict[str, Table | NDArray[Any]] = dict(columns.tables())
            if block.points.pose is not None:
                arrays["pose"] = block.points.pose
            if block.points.timestamp is not None:
                arrays["timestamp"] = np.array(block.points.timestamp, np.float64)
            with output.file(f"{frame.stem}.npz") as file:
                write_npz(file, arrays)
    write_palette(palette, output)


def _arrays(block: LabeledFrame, palette: Palette) -> dict[str, NDArray[Any]]:
    keep, points, label = block.keep, block.points, block.label[block.keep]
    arrays: dict[str, NDArray[Any]] = {"xyz": points.xyz[keep]}
    if points.rgb is not None:
        arrays["rgb"] = points.rgb[keep]
    if points.intensity is not None:
        arrays["intensity"] = points.intensity[keep]
    arrays["label"] = label
    arrays["category"] = palette.category(label)
    arrays["instance"] = palette.instance(label)
    arrays["provenance"] = block.provenance[keep]
    arrays["deleted"] = block.deleted
    return arrays | other_columns(block, (*arrays, *KNOWN_ARRAYS), keep)


def write_cuts(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """``00003_pin-1/NNNNNN.ply`` for each label and frame where it has points.

    The field ``row`` is the number of each point in its frame.
    """
    folders = {entry.id: _folder(entry) for entry in palette.entries}
    for frame in frames:
        sizes = frame.sizes
        for label in (np.flatnonzero(sizes[1:]) + 1).tolist():
            folder = folders.get(label, f"{label:05d}")
            table = Table(int(sizes[label]), partial(_points, frame, palette, label))
            with output.file(f"{folder}/{frame.stem}.ply") as file:
                write_ply(file, table)
    write_palette(palette, output)


def _points(frame: ExportFrame, palette: Palette, label: int) -> Iterator[Columns]:
    first = 0
    for block in frame.blocks():
        mine = np.flatnonzero((block.label == label) & ~block.deleted)
        made = point_columns(block, palette, mine) | {ROW: (first + mine).astype(np.uint32)}
        yield made | other_columns(block, made, mine)
        first += block.count


def _folder(entry: PaletteEntry) -> str:
    """Return a folder name that is valid on every file system and unique by the label's id."""
    slug = re.sub(r"[^a-z0-9]+", "-", entry.name.lower()).strip("-")[:40]
    return f"{entry.id:05d}_{slug}" if slug else f"{entry.id:05d}"
