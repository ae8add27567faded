"""Layouts that training code reads as they are: Pointcept's and OpenPCDet's custom dataset."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.exports.boxes import upright_axes, upright_box
from pointbrush.formats.exports.labeled import ExportFrame, LabeledFrame, Palette, category_of
from pointbrush.formats.exports.output import Output
from pointbrush.formats.exports.points import write_palette
from pointbrush.formats.npy import write_column
from pointbrush.formats.numbering import TRAINING_NUMBERS
from pointbrush.formats.table import Spools

VALIDATION = 5
"""Every so many frames one is for validation, where there are that many."""
NONE = -1
"""Value of Pointcept for points without a class or an instance."""
FEWEST = 5
"""Points that a box must hold to be worth learning."""


def split_of(position: int, name: str = "val") -> str:
    """The split of a frame by its position in the export: every fifth is for validation."""
    return name if position % VALIDATION == VALIDATION - 1 else "train"


def write_pointcept(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """``train/NNNNNN/`` and ``val/NNNNNN/``: coord, color, strength, segment, instance ``.npy``.

    ``segment`` is the number of ``classes.json``, the same in all recordings of a workspace;
    ``instance`` is the label's id; both -1 where there is no label.
    """
    segments = _places(palette)
    for position, frame in enumerate(frames):
        folder = f"{split_of(position)}/{frame.stem}"
        with ExitStack() as stack:
            columns = Spools(stack)
            for block in frame.blocks():
                columns.add(_scene(block, palette, segments))
            for name, table in columns.tables().items():
                with output.file(f"{folder}/{name}.npy") as file:
                    write_column(file, table)
    write_palette(palette, output)


def _places(palette: Palette) -> NDArray[np.int16]:
    """The training number (65536,) of each category by its own number; -1 for none."""
    places = np.full(1 << 16, NONE, np.int16)
    for name, place in palette.numbers_in(TRAINING_NUMBERS).items():
        places[palette.categories[name]] = place
    return places


def _scene(
    block: LabeledFrame, palette: Palette, segments: NDArray[np.int16]
) -> dict[str, NDArray[Any]]:
    keep, points = block.keep, block.points
    label = block.label[keep]
    scene: dict[str, NDArray[Any]] = {"coord": points.xyz[keep].astype(np.float32)}
    if points.rgb is not None:
        scene["color"] = points.rgb[keep]
    if points.intensity is not None:
        scene["strength"] = points.intensity[keep].reshape(-1, 1)
    scene["segment"] = segments[palette.category(label)]
    scene["instance"] = np.where(label > 0, label.astype(np.int32), NONE)
    return scene


def write_openpcdet(frames: Iterable[ExportFrame], palette: Palette, output: Output) -> None:
    """OpenPCDet's custom dataset: ``points/``, ``labels/`` and ``ImageSets/``.

    ``points/NNNNNN.npy`` are x y z intensity in float32, z up, x ahead; ``labels/NNNNNN.txt`` lines
    ``x y z dx dy dz heading class`` of upright boxes.
    """
    splits: dict[str, list[str]] = {"train": [], "val": []}
    entries = {entry.id: entry for entry in palette.entries}
    for position, frame in enumerate(frames):
        axes = upright_axes(frame.up)
        boxes: dict[int, list[NDArray[np.float64]]] = {}
        with ExitStack() as stack:
            columns = Spools(stack)
            for block in frame.blocks():
                keep = block.keep
                xyz = block.points.xyz[keep].astype(np.float64) @ axes.T
                columns.add({"points": _with_intensity(block, keep, xyz)})
                for label in np.unique(block.label[keep]).tolist():
                    if label:
                        boxes.setdefault(label, []).append(xyz[block.label[keep] == label])
            with output.file(f"points/{frame.stem}.npy") as file:
                write_column(file, columns.tables()["points"])
        lines = []
        for label, parts in sorted(boxes.items()):
            xyz = np.concatenate(parts)
            if len(xyz) >= FEWEST:
                entry = entries.get(label)
                name = category_of(entry) if entry else f"label {label}"
                lines.append(_box_line(xyz, "_".join(name.split())))
        with output.file(f"labels/{frame.stem}.txt") as file:
            file.write("".join(f"{line}\n" for line in lines).encode())
        splits[split_of(position)].append(frame.stem)
    for name, stems in splits.items():
        with output.file(f"ImageSets/{name}.txt") as file:
            file.write("".join(f"{stem}\n" for stem in stems).encode())
    write_palette(palette, output)


def _with_intensity(
    block: LabeledFrame, keep: NDArray[np.int64], xyz: NDArray[np.float64]
) -> NDArray[np.float32]:
    table = np.zeros((len(keep), 4), np.float32)
    table[:, :3] = xyz
    if block.points.intensity is not None:
        table[:, 3] = block.points.intensity[keep]
    return table


def _box_line(xyz: NDArray[np.float64], name: str) -> str:
    """x y z of the middle, sizes along the box's own axes, heading about z, class."""
    box = upright_box(xyz, np.array([0.0, 0.0, 1.0]))
    numbers = (*box.center.tolist(), *box.size.tolist(), box.yaw)
    return " ".join(f"{value:.4f}" for value in numbers) + f" {name}"
