"""The file ``export.json``: format, files by frame, and losses of the format."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, BinaryIO

from pointbrush.formats.readers.npy import write_column
from pointbrush.formats.tables.numbering import Numbering
from pointbrush.formats.tables.table import Table
from pointbrush.formats.writers.labeled import ExportFrame, LabeledFrame, Palette
from pointbrush.formats.writers.output import Output
from pointbrush.formats.writers.sensors import parts_document

NAME = "export.json"
CLASSES = "classes.json"
TIMES = "times"
"""Key of the seconds of frames, which match the rows of tables to frames."""
PLACEMENT = "T_export_source"
"""Key of the rows of the transform (4, 4) from source to export coordinates."""
VERSION = 1
ROW = "row"
"""Field of a cut's points: the number of each in its frame."""
SENSORS = "sensors"
"""Key of the sensors of a frame."""
DELETED = "deleted"
"""Folder of the masks (N,) bool of deleted points, and key of the masks' names."""


class FrameLog:
    """An Output that records the files that are written during each frame.

    ``masks``: write the mask of a frame's deleted points, if any, because the format itself only
    holds the other points.
    """

    def __init__(self, output: Output, *, masks: bool) -> None:
        self._output, self._masks = output, masks
        self._current: list[str] | None = None
        self.files: dict[int, list[str]] = {}
        """Names of the files by the frame's number in its recording."""
        self.masks: dict[int, str] = {}
        """Names of the masks of deleted points."""
        self.sensors: dict[int, dict[str, Any]] = {}
        """The sensors of each frame of several."""

    def file(self, name: str) -> AbstractContextManager[BinaryIO]:
        """Open ``name`` for writing."""
        if self._current is not None:
            self._current.append(name)
        return self._output.file(name)

    def frames(self, frames: Iterable[ExportFrame]) -> Iterator[ExportFrame]:
        """Yield the frames, each with a new list of files."""
        for frame in frames:
            self._current = self.files.setdefault(frame.index, [])
            if isinstance(frame, LabeledFrame) and frame.points.parts:
                self.sensors[frame.index] = parts_document(frame.points)
            elif isinstance(frame, LabeledFrame) and frame.sensor:
                self.sensors[frame.index] = {frame.sensor: {}}
            yield frame
            if self._masks and frame.kept < frame.count:
                self._write_mask(frame)
        self._current = None

    def _write_mask(self, frame: ExportFrame) -> None:
        masks = Table(frame.count, lambda: ({DELETED: block.deleted} for block in frame.blocks()))
        self.masks[frame.index] = f"{DELETED}/{frame.stem}.npy"
        with self._output.file(self.masks[frame.index]) as file:
            write_column(file, masks)


def write_classes(output: Output, palette: Palette, numbering: Numbering | None) -> None:
    """Write ``classes.json``: the number of each category in the export's numbering."""
    numbers = palette.categories if numbering is None else palette.numbers_in(numbering)
    with output.file(CLASSES) as file:
        file.write(json.dumps(numbers, indent=1, ensure_ascii=False).encode())


def write_about(
    output: Output,
    format: str,
    log: FrameLog,
    cannot_hold: Sequence[str],
    more: Mapping[str, Any],
) -> None:
    """Write ``export.json``; ``log`` has seen all frames, ``more``: the format's own entries."""
    document = {
        "format": format,
        "version": VERSION,
        "cannot_hold": list(cannot_hold),
        "frames": [
            {"frame": index, "files": names}
            | ({DELETED: log.masks[index]} if index in log.masks else {})
            | ({SENSORS: log.sensors[index]} if index in log.sensors else {})
            for index, names in log.files.items()
        ],
        **more,
    }
    with output.file(NAME) as file:
        file.write(json.dumps(document, indent=1, ensure_ascii=False).encode())
