"""Labels without points: one value for every row of the source's files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from typing import Any, BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.readers.npy import write_column
from pointbrush.formats.tables.table import Spools
from pointbrush.formats.writers.labeled import ExportFrame, LabeledFrame, Palette
from pointbrush.formats.writers.output import Output
from pointbrush.formats.writers.points import write_palette

MANIFEST = "manifest.json"
Layers = dict[str, NDArray[Any]]


def write_labels_only(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """``label/NNNNNN.npy`` uint16 (0 where deleted), ``provenance/`` uint8, ``deleted/`` bool.

    Rows of invalid points, which the import left out, are included without a label.
    ``manifest.json`` has the counts, and size and SHA-256 of each file.
    """
    frames_written: list[dict[str, Any]] = []
    for frame in frames:
        files: dict[str, Any] = {}
        labelled = 0
        with ExitStack() as stack:
            layers = Spools(stack)
            for block in _blocks(frame):
                layers.add(block)
                labelled += int(np.count_nonzero(block["label"]))
            for layer, table in layers.tables().items():
                name = f"{layer}/{frame.stem}.npy"
                with output.file(name) as file:
                    hashed = _Hashed(file)
                    write_column(cast(BinaryIO, hashed), table)
                files[name] = {"bytes": hashed.count, "sha256": hashed.digest}
                rows = table.count
        frames_written.append(
            {
                "frame": frame.index,
                "rows": rows,
                "points": frame.count,
                "invalid": rows - frame.count,
                "left_out": frame.count + frame.dropped - rows,
                "labelled": labelled,
                "files": files,
            }
        )
    document = {
        "format": "pointbrush labels-only",
        "version": 1,
        "rows": "one for every row of the source, in its order, invalid points too; an import of "
        "before rows were kept has its invalid points left out (left_out)",
        "frames": frames_written,
    }
    with output.file(MANIFEST) as file:
        file.write(json.dumps(document, indent=1).encode())
    write_palette(palette, output)


class _Hashed:
    """Writes bytes to a file, counts them and computes their SHA-256."""

    def __init__(self, file: BinaryIO) -> None:
        self._file, self._hash, self.count = file, hashlib.sha256(), 0

    def write(self, data: bytes) -> int:
        self._hash.update(data)
        self.count += len(data)
        return self._file.write(data)

    @property
    def digest(self) -> str:
        return self._hash.hexdigest()


def _blocks(frame: ExportFrame) -> Iterator[Layers]:
    """Yield layers of the source's rows, block by block; rows without a point are 0."""
    if frame.rows is None:
        yield from map(_layers, frame.blocks())
        return
    first = done = 0
    for block in frame.blocks():
        layers = _layers(block)
        rows = frame.rows[first : first + block.count] - done
        first += block.count
        last = first == frame.count
        size = frame.count + frame.dropped - done if last else int(rows[-1]) + 1
        yield {name: _spread(values, rows, size) for name, values in layers.items()}
        done += size


def _spread(values: NDArray[Any], rows: NDArray[np.int64], size: int) -> NDArray[Any]:
    spread = np.zeros(size, values.dtype)
    spread[rows] = values
    return spread


def _layers(block: LabeledFrame) -> Layers:
    return {
        "label": np.where(block.deleted, 0, block.label).astype(np.uint16),
        "provenance": block.provenance,
        "deleted": block.deleted,
    }
