"""Labelled frames written to files: one exporter per format, whole or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from pointbrush.errors import BadInputError, DamagedError
from pointbrush.formats.exports import boxes, labels_only, points, semantickitti, training
from pointbrush.formats.exports.labeled import (
    BlockedFrame,
    ExportFrame,
    LabeledFrame,
    Palette,
    PaletteEntry,
    category_names,
    sizes_of,
)
from pointbrush.formats.exports.output import Output, folder_output, single_output, stream_output


@dataclass(frozen=True, slots=True)
class Export:
    """An export format: ``write`` puts frames and palette into an Output.

    ``endings`` are those of a single file that holds one frame, if the format has such files.
    """

    name: str
    title: str
    write: Callable[[Iterable[ExportFrame], Palette, Output], None]
    endings: tuple[str, ...] = ()


GAPS = "gaps.json"
"""In a streamed export: which frames are missing, and why; absent when none is."""

_ALL = (
    Export("ply", "PLY with labels", points.write_plys, (".ply",)),
    Export("npz", "NumPy arrays", points.write_npzs, (".npz",)),
    Export("pcd", "PCD with labels", points.write_pcds, (".pcd",)),
    Export("las", "LAS with labels", points.write_lass, (".las",)),
    Export("laz", "LAZ with labels", points.write_lazs, (".laz",)),
    Export("csv", "CSV with labels", points.write_csvs, (".csv",)),
    Export("semantickitti", "SemanticKITTI", semantickitti.write_semantickitti),
    Export("labels-only", "Labels without points", labels_only.write_labels_only),
    Export("cut", "One PLY per label", points.write_cuts),
    Export("pointcept", "Pointcept's scenes with splits", training.write_pointcept),
    Export("openpcdet", "OpenPCDet's custom dataset", training.write_openpcdet),
    Export("boxes", "Oriented boxes, JSON and KITTI tracking", boxes.write_boxes),
)
EXPORTS: dict[str, Export] = {entry.name: entry for entry in _ALL}


def export(
    format: str,
    frames: Iterable[ExportFrame],
    palette: Sequence[PaletteEntry],
    out: Path | BinaryIO,
    gaps: list[str] | None = None,
    numbers: Mapping[str, int] | None = None,
    datasets: Mapping[str, Mapping[str, int]] | None = None,
) -> None:
    """Write frames and palette to a new folder, a .zip, a single file, or a stream (as zip).

    Points are in source order, deleted ones left out.  Written beside the target and renamed
    when whole: nothing is half-written.  Raises BadInputError for an unknown format, a folder
    that is not empty, or a single file for several frames.

    A damaged frame raises DamagedError, unless there is a list of ``gaps``, for a stream that has
    begun: what is missing is told there, by ``frames`` too, and written as ``gaps.json``.
    ``numbers`` are the categories' numbers by name; without them they are counted.  ``datasets``
    are the numbers that they have in each dataset.
    """
    if format not in EXPORTS:
        raise BadInputError(f"format: expected one of {', '.join(EXPORTS)}, got {format!r}")
    entry = EXPORTS[format]
    if not isinstance(out, Path):
        context = stream_output(out)
    elif out.suffix.lower() in entry.endings or out.suffix.lower() == ".zip":
        context = single_output(out)
    else:
        context = folder_output(out)
    with context as output:
        try:
            entry.write(frames, Palette(palette, numbers, datasets), output)
        except DamagedError as error:
            if gaps is None:
                raise
            gaps.append(f"{error}; nothing was written of it, nor of what comes after it")
        if gaps:
            with output.file(GAPS) as file:
                file.write(json.dumps({"gaps": gaps}, indent=1, ensure_ascii=False).encode())


__all__ = [
    "EXPORTS",
    "GAPS",
    "BlockedFrame",
    "Export",
    "ExportFrame",
    "LabeledFrame",
    "Output",
    "Palette",
    "PaletteEntry",
    "category_names",
    "export",
    "sizes_of",
]
