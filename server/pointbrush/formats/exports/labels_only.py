"""Labels without points: one value per source point, so that they fit the source files."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.exports.labeled import ExportFrame, LabeledFrame, Palette
from pointbrush.formats.exports.output import Output
from pointbrush.formats.exports.points import write_palette
from pointbrush.formats.exports.spools import Spools
from pointbrush.formats.npy import write_column


def write_labels_only(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """``label/NNNNNN.npy`` uint16 (0 where deleted), ``provenance/`` uint8, ``deleted/`` bool."""
    for frame in frames:
        with ExitStack() as stack:
            layers = Spools(stack)
            for block in frame.blocks():
                layers.add(_layers(block))
            for layer, table in layers.tables().items():
                with output.file(f"{layer}/{frame.stem}.npy") as file:
                    write_column(file, table)
    write_palette(palette, output)


def _layers(block: LabeledFrame) -> dict[str, NDArray[Any]]:
    return {
        "label": np.where(block.deleted, 0, block.label).astype(np.uint16),
        "provenance": block.provenance,
        "deleted": block.deleted,
    }
