"""Layouts that training code reads directly: Pointcept and OpenPCDet's custom dataset."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.boxes.figures import FrameBox
from pointbrush.formats.boxes.openpcdet import box_line
from pointbrush.formats.readers.npy import write_column
from pointbrush.formats.tables.numbering import TRAINING_NUMBERS
from pointbrush.formats.tables.table import Spools
from pointbrush.formats.writers.about import PLACEMENT
from pointbrush.formats.writers.boxes import upright_box
from pointbrush.formats.writers.labeled import (
    ExportFrame,
    LabeledFrame,
    Palette,
    Split,
    category_of,
)
from pointbrush.formats.writers.output import Output
from pointbrush.formats.writers.placement import (
    Matrix,
    placed,
    placement_of,
)
from pointbrush.formats.writers.points import write_palette
from pointbrush.formats.writers.whole_boxes import boxes_of
from pointbrush.geometry.rotations import upright_axes

NONE = -1
"""Value of Pointcept for points without a class or an instance."""
FEWEST = 5
"""Least points of a box in the training set."""


class _Scenes:
    """The frames of a recording with splits and names of their scenes, in common coordinates.

    ``T_export_source`` (4, 4) and ``facts`` are available after the iteration.
    """

    def __init__(
        self, frames: Iterable[ExportFrame], axes: Callable[[Matrix], Matrix] | None = None
    ) -> None:
        """``axes(up)`` turns the points, (3, 3); without it they keep the source's axes."""
        self._frames, self._axes = frames, axes
        self._split = Split()
        self.names: dict[str, list[str]] = {"train": [], "val": []}
        """Scenes of each split."""
        self.T_export_source = np.eye(4)

    def __iter__(self) -> Iterator[tuple[ExportFrame, str, str]]:
        at_place = False
        for frame in self._frames:
            if not at_place and frame.count:
                turn = np.eye(3) if self._axes is None else self._axes(frame.up)
                self.T_export_source, at_place = placement_of(frame, turn), True
            name = f"{frame.recording}_{frame.stem}" if frame.recording else frame.stem
            self._split, split = frame.split, frame.split.of(frame.index)
            self.names[split].append(name)
            yield frame, split, name

    def facts(self) -> dict[str, Any]:
        """Return the entries for ``export.json``."""
        split = {"by": self._split.by, **self.names}
        return {"split": split, PLACEMENT: self.T_export_source.tolist()}


def write_pointcept(
    frames: Iterable[ExportFrame], palette: Palette, output: Output
) -> dict[str, Any]:
    """Write Pointcept's scenes, ``train/RECORDING_NNNNNN/`` or ``val/…`` by the frame's split.

    Each has coord, color, strength, segment and instance as ``.npy``.
    ``segment`` is the number of ``classes.json``, the same in all recordings of a workspace;
    ``instance`` is the label's id; both -1 where there is no label.
    """
    segments = _places(palette)
    scenes = _Scenes(frames)
    for frame, split, name in scenes:
        folder = f"{split}/{name}"
        with ExitStack() as stack:
            columns = Spools(stack)
            for block in frame.blocks():
                columns.add(_scene(block, palette, segments, scenes.T_export_source))
            for column, table in columns.tables().items():
                with output.file(f"{folder}/{column}.npy") as file:
                    write_column(file, table)
    write_palette(palette, output)
    return scenes.facts()


def _places(palette: Palette) -> NDArray[np.int16]:
    """The training number (65536,) of each category by its own number; -1 for none."""
    places = np.full(1 << 16, NONE, np.int16)
    for name, place in palette.numbers_in(TRAINING_NUMBERS).items():
        places[palette.categories[name]] = place
    return places


def _scene(
    block: LabeledFrame,
    palette: Palette,
    segments: NDArray[np.int16],
    T_export_source: Matrix,
) -> dict[str, NDArray[Any]]:
    keep, points = block.keep, block.points
    label = block.label[keep]
    coord = placed(T_export_source, points.xyz[keep]).astype(np.float32)
    scene: dict[str, NDArray[Any]] = {"coord": coord}
    if points.rgb is not None:
        scene["color"] = points.rgb[keep]
    if points.intensity is not None:
        scene["strength"] = points.intensity[keep].reshape(-1, 1)
    scene["segment"] = segments[palette.category(label)]
    scene["instance"] = np.where(label > 0, label.astype(np.int32), NONE)
    return scene


def write_openpcdet(
    frames: Iterable[ExportFrame], palette: Palette, output: Output, *, whole: bool = False
) -> dict[str, Any]:
    """Write OpenPCDet's custom dataset: ``points/``, ``labels/`` and ``ImageSets/``.

    ``points/RECORDING_NNNNNN.npy`` are x y z intensity in float32, z up, x ahead; the ``.txt`` of
    that name in ``labels`` has lines ``x y z dx dy dz heading class`` of upright boxes: around the
    points of each label, or with ``whole`` the boxes of the labels.
    """
    scenes = _Scenes(frames, upright_axes)
    for frame, _, name in scenes:
        boxes: dict[int, list[Matrix]] = {}
        with ExitStack() as stack:
            columns = Spools(stack)
            for block in frame.blocks():
                keep = block.keep
                xyz, ids = placed(scenes.T_export_source, block.points.xyz[keep]), block.label[keep]
                columns.add({"points": _with_intensity(block, keep, xyz)})
                for label in np.unique(ids[ids > 0]).tolist():
                    boxes.setdefault(label, []).append(xyz[ids == label])
            with output.file(f"points/{name}.npy") as file:
                write_column(file, columns.tables()["points"])
        with output.file(f"labels/{name}.txt") as file:
            lines = _whole_lines(frame, scenes) if whole else _box_lines(boxes, palette)
            file.write("".join(f"{line}\n" for line in lines).encode())
    for split, names in scenes.names.items():
        with output.file(f"ImageSets/{split}.txt") as file:
            file.write("".join(f"{name}\n" for name in names).encode())
    write_palette(palette, output)
    return scenes.facts()


def _box_lines(boxes: Mapping[int, list[Matrix]], palette: Palette) -> Iterator[str]:
    """Yield a line for each label with enough points, in parts (N, 3), for a box."""
    entries = {entry.id: entry for entry in palette.entries}
    for label, parts in sorted(boxes.items()):
        xyz = np.concatenate(parts)
        if len(xyz) >= FEWEST:
            entry = entries.get(label)
            name = category_of(entry) if entry else f"label {label}"
            box = upright_box(xyz, np.array([0.0, 0.0, 1.0]))
            yield box_line(FrameBox(name, "", box.center, box.size, box.R))


def _whole_lines(frame: ExportFrame, scenes: _Scenes) -> Iterator[str]:
    """Yield a line for each box of a frame."""
    for box in boxes_of(frame).boxes:
        yield box_line(box.moved(scenes.T_export_source))


def _with_intensity(
    block: LabeledFrame, keep: NDArray[np.int64], xyz: NDArray[np.float64]
) -> NDArray[np.float32]:
    table = np.zeros((len(keep), 4), np.float32)
    table[:, :3] = xyz
    if block.points.intensity is not None:
        table[:, 3] = block.points.intensity[keep]
    return table
