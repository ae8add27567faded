"""Export of labelled frames to files, atomic, with one exporter per format."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Literal

from pointbrush.errors import BadInputError, DamagedError
from pointbrush.formats.boxes.writing import ATTRIBUTES as BOX_ATTRIBUTES
from pointbrush.formats.boxes.writing import BOX_WRITERS, HEADING, OBJECTS, PRECISE, TILT
from pointbrush.formats.tables.numbering import (
    KITTI_NUMBERS,
    LAS_NUMBERS,
    TRAINING_NUMBERS,
    Numbering,
)
from pointbrush.formats.writers import boxes, labels_only, masks, points, semantickitti, training
from pointbrush.formats.writers.about import FrameLog, write_about, write_classes
from pointbrush.formats.writers.labeled import (
    BlockedFrame,
    ExportFrame,
    LabeledFrame,
    Palette,
    PaletteEntry,
    Split,
    sizes_of,
)
from pointbrush.formats.writers.output import Output, folder_output, single_output, stream_output
from pointbrush.formats.writers.whole_boxes import write_whole_boxes

Purpose = Literal["points with labels", "labels only", "training sets", "boxes"]
"""The use of an export; the page groups the formats by it."""


@dataclass(frozen=True, slots=True)
class Export:
    """An export format: ``write`` puts frames and palette into an Output.

    ``title`` and ``content`` are shown to users; ``cannot_hold`` lists the properties of points and
    labels that the format loses.  ``export.json`` contains the result of ``write``.  ``endings``:
    endings of a single file that holds one frame, if the format has such files.  ``masks``: deleted
    points are left out, and a mask beside the frame marks them.
    """

    name: str
    title: str
    content: str
    write: Callable[[Iterable[ExportFrame], Palette, Output], Mapping[str, Any] | None]
    cannot_hold: tuple[str, ...] = ()
    endings: tuple[str, ...] = ()
    masks: bool = True
    purpose: Purpose = "points with labels"
    numbering: Numbering | None = None
    """Numbers of classes in its files; None: the workspace's numbers."""
    splits: bool = False
    """Its frames are split into training and validation."""
    whole_boxes: bool = False
    """It contains the boxes of labels as drawn or fitted, not boxes of the visible points."""
    pictures: bool = False
    """It contains labels in the pictures of cameras, not of points."""
    labels: tuple[str, str] | None = None
    """Format of labels that reads it, and the pattern of its label files; None: a file of points
    for each frame."""

    @property
    def classes(self) -> bool:
        """Whether objects in its files have a class: a label without a category becomes a class."""
        return self.numbering is not None or self.whole_boxes or self.write is boxes.write_boxes

    @property
    def read_as(self) -> tuple[str, str]:
        """The format for reading its labels, and a pattern of the files with labels."""
        return self.labels or ("points", f"*{self.endings[0]}")


GAPS = "gaps.json"
"""In a streamed export: the missing frames and the reasons; absent if no frame is missing."""

_PROVENANCE = "provenance"
_FIELDS = "other point fields"
_WIDE = "integers beyond 2^53"
_SINGLE = "coordinates beyond 32-bit floats"
_COLORS = "colours"
_BOXES = "point labels"
_POINTS = "points and point labels"
_UNSEEN = ("points", "labels of points that no camera sees")
_NAMELESS = ("label names", OBJECTS, _COLORS)

_ALL = (
    Export("ply", "PLY", "points and labels", points.write_plys, (_PROVENANCE, _WIDE), (".ply",)),
    Export("npz", "NPZ", "NumPy arrays", points.write_npzs, (), (".npz",)),
    Export(
        "semantickitti",
        "SemanticKITTI",
        "the .bin and .label files of the dataset",
        semantickitti.write_semantickitti,
        (_PROVENANCE, _COLORS, _FIELDS, _SINGLE),
        numbering=KITTI_NUMBERS,
        labels=("semantickitti", "*.label"),
    ),
    Export("pcd", "PCD", "points and labels", points.write_pcds, (_PROVENANCE,), (".pcd",)),
    Export(
        "las",
        "LAS",
        "points, labels, source fields",
        points.write_lass,
        (_PROVENANCE,),
        (".las",),
        numbering=LAS_NUMBERS,
    ),
    Export(
        "laz",
        "LAZ",
        "compressed LAS",
        points.write_lazs,
        (_PROVENANCE,),
        (".laz",),
        numbering=LAS_NUMBERS,
    ),
    Export("csv", "CSV", "one row per point", points.write_csvs, (_PROVENANCE,), (".csv",)),
    Export(
        "labels-only",
        "Label arrays",
        "one array of labels per frame",
        labels_only.write_labels_only,
        masks=False,
        purpose="labels only",
        labels=("npy", "label/*.npy"),
    ),
    Export(
        "cut",
        "Cut by label",
        "one file of points per label",
        points.write_cuts,
        (_PROVENANCE, _WIDE, "unlabeled points"),
        masks=False,
        labels=("points", "*.ply"),
    ),
    Export(
        "pointcept",
        "Pointcept",
        "NumPy arrays, one folder per frame",
        training.write_pointcept,
        (_PROVENANCE, _FIELDS, _SINGLE),
        purpose="training sets",
        numbering=TRAINING_NUMBERS,
        splits=True,
        labels=("npy", "instance.npy"),
    ),
    Export(
        "openpcdet",
        "OpenPCDet",
        "points and boxes of the visible parts",
        training.write_openpcdet,
        (
            _BOXES,
            *_NAMELESS,
            _FIELDS,
            _SINGLE,
            f"labels with fewer than {training.FEWEST} points",
        ),
        masks=False,
        purpose="training sets",
        numbering=TRAINING_NUMBERS,
        splits=True,
        labels=("openpcdet", "labels/*.txt"),
    ),
    *(
        Export(
            name,
            kind.title,
            kind.content,
            partial(write_whole_boxes, kind),
            (_POINTS, *kind.cannot_hold),
            masks=False,
            purpose="boxes",
            whole_boxes=True,
            labels=kind.read_as,
        )
        for name, kind in BOX_WRITERS.items()
    ),
    Export(
        "openpcdet-boxes",
        "OpenPCDet, whole boxes",
        "points and whole boxes",
        partial(training.write_openpcdet, whole=True),
        (_BOXES, *_NAMELESS, _FIELDS, _SINGLE, TILT, BOX_ATTRIBUTES, HEADING, PRECISE),
        masks=False,
        purpose="training sets",
        numbering=TRAINING_NUMBERS,
        splits=True,
        whole_boxes=True,
        labels=("openpcdet", "labels/*.txt"),
    ),
    Export(
        "boxes",
        "Boxes, visible parts",
        "a box around the points of each label",
        boxes.write_boxes,
        (_POINTS, "full size of partly visible objects"),
        masks=False,
        purpose="labels only",
        labels=("boxes", boxes.FILE),
    ),
    Export(
        "masks-png",
        "Masks, PNG",
        "an image of labels for each camera and frame",
        masks.write_png_masks,
        (*_UNSEEN, _PROVENANCE),
        masks=False,
        purpose="labels only",
        pictures=True,
        labels=("masks-png", "labels/*/*.png"),
    ),
    Export(
        "masks-coco",
        "Masks, COCO",
        "objects in the pictures of cameras, with tracks",
        masks.write_coco_masks,
        (*_UNSEEN, _PROVENANCE),
        masks=False,
        purpose="labels only",
        pictures=True,
        labels=("masks-coco", masks.COCO_FILE),
    ),
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

    Points are in source order, deleted ones left out.  The export is written beside the target and
    renamed when it is complete.  Raises BadInputError for an unknown format, a folder that is not
    empty, or a single file for several frames.

    A damaged frame raises DamagedError, unless there is a list of ``gaps``, for a stream that has
    begun: missing frames are added to it, by ``frames`` as well, and written as ``gaps.json``.
    ``numbers``: the categories' numbers by name; without them, categories are counted.
    ``datasets``: the categories' numbers in each dataset.
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
            log = FrameLog(output, masks=entry.masks)
            named = Palette(palette, numbers, datasets)
            more = entry.write(log.frames(frames), named, log) or {}
            write_classes(output, named, entry.numbering)
            write_about(output, entry.name, log, entry.cannot_hold, more)
        except DamagedError as error:
            if gaps is None:
                raise
            gaps.append(f"{error}; this frame and the following frames were not written")
        if gaps:
            with output.file(GAPS) as file:
                file.write(json.dumps({"gaps": gaps}, indent=1, ensure_ascii=False).encode())
