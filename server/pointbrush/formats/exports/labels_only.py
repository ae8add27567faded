"""Labels without points: one value per source point, so that they fit the source files."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.exports.labeled import LabeledFrame, Palette
from pointbrush.formats.exports.output import Output
from pointbrush.formats.exports.points import write_palette


def write_labels_only(frames: Iterable[LabeledFrame], palette: Palette, output: Output) -> None:
    """``label/NNNNNN.npy`` uint16 (0 where deleted), ``provenance/`` uint8, ``deleted/`` bool."""
    for frame in frames:
        layers: dict[str, NDArray[Any]] = {
            "label": np.where(frame.deleted, 0, frame.label).astype(np.uint16),
            "provenance": frame.provenance,
            "deleted": frame.deleted,
        }
        for layer, values in layers.items():
            with output.file(f"{layer}/{frame.stem}.npy") as file:
                np.save(file, values, allow_pickle=False)
    write_palette(palette, output)
