"""Each label's points of each frame as a PLY of its own."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np

from pointbrush.formats.exports.labeled import ExportFrame, Palette, PaletteEntry, point_columns
from pointbrush.formats.exports.output import Output
from pointbrush.formats.exports.points import write_palette
from pointbrush.formats.ply import write_ply
from pointbrush.formats.table import Columns, Table


def write_cuts(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """``00003_pin-1/NNNNNN.ply`` for each label and frame where it has points."""
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
    for block in frame.blocks():
        mine = np.flatnonzero((block.label == label) & ~block.deleted)
        yield point_columns(block, palette, mine)


def _folder(entry: PaletteEntry) -> str:
    """A name for every file system, unique by the label's id."""
    slug = re.sub(r"[^a-z0-9]+", "-", entry.name.lower()).strip("-")[:40]
    return f"{entry.id:05d}_{slug}" if slug else f"{entry.id:05d}"
