"""Each label's points of each frame as a PLY of its own."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from pointbrush.formats.exports.labeled import LabeledFrame, Palette, PaletteEntry, point_columns
from pointbrush.formats.exports.output import Output
from pointbrush.formats.exports.points import write_palette
from pointbrush.formats.ply import write_ply


def write_cuts(frames: Iterable[LabeledFrame], palette: Palette, output: Output) -> None:
    """``00003_pin-1/NNNNNN.ply`` for each label and frame where it has points."""
    folders = {entry.id: _folder(entry) for entry in palette.entries}
    for frame in frames:
        alive = np.where(frame.deleted, 0, frame.label)
        for label in np.unique(alive[alive > 0]).tolist():
            folder = folders.get(label, f"{label:05d}")
            with output.file(f"{folder}/{frame.stem}.ply") as file:
                write_ply(file, point_columns(frame, palette, np.flatnonzero(alive == label)))
    write_palette(palette, output)


def _folder(entry: PaletteEntry) -> str:
    """A name for every file system, unique by the label's id."""
    slug = re.sub(r"[^a-z0-9]+", "-", entry.name.lower()).strip("-")[:40]
    return f"{entry.id:05d}_{slug}" if slug else f"{entry.id:05d}"
