"""Label files of other tools: search at a place, and matching to frames."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from pointbrush.errors import BadInputError, NotFoundError, TooLargeError
from pointbrush.formats.boxes.registry import BOX_READERS, is_box_file
from pointbrush.formats.masks.registry import MASK_FORMATS, mask_files
from pointbrush.formats.options import Limits, ReadOptions, read_bytes
from pointbrush.formats.own_export import OwnExport, own_export
from pointbrush.formats.point_labels import (
    LINE_ENDINGS,
    READERS,
    PointLabels,
    has_label_array,
    has_label_lines,
)
from pointbrush.formats.readers.s3dis import FOLDER as OBJECTS
from pointbrush.formats.readers.s3dis import is_object
from pointbrush.formats.registry import format_by_name
from pointbrush.formats.tables.class_maps import class_file, stated_classes
from pointbrush.formats.tables.datasets import LAS, NUSCENES, SEMANTIC_KITTI, ClassName, Dataset
from pointbrush.formats.tables.names import LABEL_FORMATS
from pointbrush.formats.tables.palette import SourceLabel, own_palette
from pointbrush.formats.times.timing import TIME_FILES, in_order

LEVELS = 4
"""Folders below a path that are searched for label files."""
_DATASETS: Mapping[str, Dataset] = MappingProxyType({
    "semantickitti": SEMANTIC_KITTI, "lidarseg": NUSCENES, "panoptic": NUSCENES, "las": LAS,
})  # fmt: skip
"""Dataset that defines the label numbers of a format."""
LISTS = "ImageSets"
"""Folder of lists of pictures' names, which may be numbers."""
_ENDINGS = {"semantickitti": (".label",), "las": (".las", ".laz")}
_LIKE_LABELS = re.compile("label|segm|class|semantic")


@dataclass(frozen=True, slots=True, eq=False)
class LabelFiles:
    """Label files in the order of frames: their format, and the names of their numbers.

    ``own``: labels by id if the files have a palette of pointbrush; the numbers are then its ids.
    ``dataset``: dataset that defines the numbers, "" if it is unknown.
    """

    format: str
    paths: tuple[Path, ...]
    names: Mapping[int, ClassName]
    own: Mapping[int, SourceLabel]
    dataset: str = ""
    export: OwnExport | None = None
    """The export of pointbrush that the files are of, which lists the frame of each."""

    @property
    def file_names(self) -> list[str]:
        """Return the names for matching files to frames, each with the name of its folder."""
        rooms = (path.parent if path.name == OBJECTS else path for path in self.paths)
        return [f"{path.parent.name}/{path.name}" for path in rooms]

    def read(self, path: Path, options: ReadOptions) -> PointLabels:
        """Return the labels of one file.  Raises BadInputError, TooLargeError."""
        return READERS[self.format](path, options)


def find_label_files(
    place: Path, format: str | None, names: Mapping[int, ClassName], limits: Limits
) -> LabelFiles:
    """Find the label files at ``place``, a file or a folder.

    Raises NotFoundError, BadInputError for a folder without any or an unknown format.
    """
    if not place.exists():
        raise NotFoundError(f"path: expected a file or folder, {place} does not exist")
    if format is not None and format not in LABEL_FORMATS:
        raise BadInputError(f"format: expected one of {', '.join(LABEL_FORMATS)}, got {format!r}")
    export = own_export(place) if format is None else None
    files = [place] if place.is_file() else _files(place, limits)
    chosen, found = _choose(files, format) if export is None else export.label_files(place)
    if not found:
        seen = ", ".join(sorted({path.suffix or path.name for path in files})[:8]) or "no files"
        raise BadInputError(
            f"{place.name}: expected files of labels ({', '.join(LABEL_FORMATS)}), got {seen}"
        )
    if chosen == "s3dis" and place.is_dir():
        found = list(dict.fromkeys(path.parent for path in found))
    own = {label.id: label for label in own_palette(found[0]) or []}
    dataset = None if own else _DATASETS.get(chosen)
    known = dict(dataset.classes) if dataset else {}
    return LabelFiles(
        chosen,
        tuple(in_order(found)),
        MappingProxyType(known | stated_classes(found[0], chosen) | dict(names)),
        MappingProxyType(own),
        dataset.name if dataset else "",
        export,
    )


def _files(folder: Path, limits: Limits) -> list[Path]:
    found: list[Path] = []
    open_: list[tuple[Path, int]] = [(folder, 0)]
    while open_:
        place, level = open_.pop()
        for path in sorted(place.iterdir()):
            if path.name.startswith(".") or path.is_symlink():
                continue
            if path.is_dir() and level < LEVELS:
                open_.append((path, level + 1))
            elif path.is_file():
                found.append(path)
                if len(found) > limits.max_files:
                    raise TooLargeError(
                        f"{folder.name}: expected at most {limits.max_files} files, got more"
                    )
    return found


def _choose(files: list[Path], format: str | None) -> tuple[str, list[Path]]:
    """Return the format and its files; formats that contain only labels are tried first."""
    if format is not None:
        return format, _fitting(files, format)
    for name in (each for each in LABEL_FORMATS if each != "las"):
        if fitting := _fitting(files, name, sure=name != "points"):
            only_numbers = name == "points" and all(map(has_label_array, fitting))
            return ("npy" if only_numbers else name), fitting
    return "points", []


def _fitting(files: list[Path], format: str, *, sure: bool = False) -> list[Path]:
    """Return the files of a format; ``sure``: see ``_fits``."""
    if format in MASK_FORMATS:
        return mask_files(files, format, sure=sure)
    return [path for path in files if _fits(path, format, sure=sure)]


def _fits(path: Path, format: str, *, sure: bool = False) -> bool:
    """Return whether a file is of a format; ``sure``: only if its name is unambiguous."""
    lower = path.name.lower()
    match format:
        case "semantickitti" | "las":
            return lower.endswith(_ENDINGS[format])
        case "lidarseg":
            return lower.endswith("_lidarseg.bin" if sure else ".bin")
        case "panoptic":
            return lower.endswith("_panoptic.npz" if sure else ".npz")
        case "labelcloud-points":
            stated = class_file(path, format) if lower.endswith(".bin") else None
            return stated is not None and (not sure or _states_segmentation(stated, path))
        case "npy":
            kept = path.parent.name not in ("provenance", "deleted")
            named = _LIKE_LABELS.search(f"{path.parent.name}/{lower}") is not None
            return lower.endswith(".npy") and kept and (named or not sure)
        case "s3dis":
            return is_object(path) and (path.parent.name == OBJECTS or not sure)
        case "lines":
            if not sure or lower.endswith(LINE_ENDINGS):
                return lower.endswith((*LINE_ENDINGS, ".txt", ".csv"))
            text = lower.endswith((".txt", ".csv")) and lower not in TIME_FILES
            return text and LISTS not in path.parts and has_label_lines(path)
    if format in BOX_READERS:
        return is_box_file(path, format)
    return format_by_name(path) is not None


def _states_segmentation(stated: Path, path: Path) -> bool:
    """Return whether labelCloud's file of classes, or the folder's name, states point labels."""
    return path.parent.name == "segmentation" or b"semantic_segmentation" in read_bytes(stated)
