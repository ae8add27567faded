"""Readers of files with one label for each point.

Rows are in the order of the file of points.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.exchange.npz import read_header
from pointbrush.exchange.npz import read_npz as read_arrays
from pointbrush.formats.options import ReadOptions, read_bytes, require_count
from pointbrush.formats.readers.kitti import read_label
from pointbrush.formats.readers.npy import read_array
from pointbrush.formats.readers.s3dis import object_files, read_objects
from pointbrush.formats.registry import format_by_name
from pointbrush.formats.tables.class_maps import GREATEST_CLASS
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.formats.tables.label_values import number_of
from pointbrush.formats.tables.numbers import is_number, parse_numbers
from pointbrush.formats.tables.palette import own_palette
from pointbrush.formats.writers.about import ROW

Numbers = NDArray[np.int64]
PANOPTIC = 1000
"""nuScenes panoptic: a category's number times this, plus the instance's."""
CLASSIFICATIONS = ("classification", "scalar_classification")
"""Names of the field of classes in LAS, and in PLY files of CloudCompare."""
LINE_ENDINGS = (".labels", ".seg")
"""Endings of text with a label in each line, from Semantic3D and ShapeNet."""
HEAD = 4096
"""Bytes of a text that are checked for one number in each line."""


@dataclass(frozen=True, slots=True, eq=False)
class PointLabels:
    """Labels of one file's points: ``category`` (N,) class numbers, 0 for none unless the map names
    it; ``instance`` (N,) numbers or None; ``rows`` (N,) numbers of the points in the frame, or
    ``xyz`` (N, 3) their coordinates; both None: all points in their order."""

    file: str
    category: Numbers
    instance: Numbers | None
    rows: Numbers | None = None
    xyz: NDArray[np.float64] | None = None


def _read_semantic_kitti(path: Path, options: ReadOptions) -> PointLabels:
    category, instance = read_label(path, options)
    return PointLabels(path.name, category.astype(np.int64), instance.astype(np.int64))


def _read_octets(path: Path, options: ReadOptions) -> PointLabels:
    """Read one byte for each class: nuScenes-lidarseg and labelCloud."""
    data = read_bytes(path)
    require_count(path.name, len(data), options.limits)
    return PointLabels(path.name, np.frombuffer(data, np.uint8).astype(np.int64), None)


def _read_panoptic(path: Path, options: ReadOptions) -> PointLabels:
    try:
        stored = read_arrays(path, options.limits.max_points * np.dtype(np.int64).itemsize)
    except BadInputError as error:
        raise BadInputError(f"{path.name}: {error}") from None
    packed = stored.get("data", next(iter(stored.values()), np.empty(0)))
    require_count(path.name, packed.size, options.limits)
    if packed.ndim != 1 or packed.dtype.kind not in "ui":
        raise BadInputError(
            f"{path.name}: expected (N,) whole numbers, got {packed.shape} {packed.dtype}"
        )
    numbers = packed.astype(np.int64)
    return PointLabels(path.name, numbers // PANOPTIC, numbers % PANOPTIC)


def _read_npy(path: Path, options: ReadOptions) -> PointLabels:
    array = read_array(path, options)
    if array.ndim == 2 and 1 in array.shape:
        array = array.reshape(-1)
    if array.ndim != 1 or array.dtype.kind not in "uifb":
        raise BadInputError(
            f"{path.name}: expected labels as (N,) whole numbers, got {array.shape} {array.dtype}"
        )
    return _of_numbers(path.name, array)


def _of_numbers(name: str, values: NDArray[np.generic]) -> PointLabels:
    numbers = number_of(name, "label", values, GREATEST_CLASS)
    return PointLabels(name, numbers.astype(np.int64), None)


def _read_lines(path: Path, options: ReadOptions) -> PointLabels:
    """Read one label in each line in the order of the points, after a header line if any."""
    head, _, rest = read_bytes(path).partition(b"\n")
    text = rest if not is_number(_line(head)) else head + b"\n" + rest
    require_count(path.name, text.count(b"\n"), options.limits)
    return _of_numbers(path.name, parse_numbers(path.name, text))


def has_label_array(path: Path) -> bool:
    """Return whether a file is a ``.npy`` of one number for each row, which no points have."""
    if path.suffix.lower() != ".npy":
        return False
    try:
        with path.open("rb") as file:
            shape, _, dtype = read_header(file)
    except BadInputError:
        return False
    return len(shape) == 1 and dtype.names is None


def has_label_lines(path: Path) -> bool:
    """Return whether the first lines of a text, except a header, have one integer each."""
    with path.open("rb") as file:
        lines = file.read(HEAD).splitlines(keepends=True)
    if len(lines) > 1 and not lines[-1].endswith((b"\n", b"\r")):
        lines = lines[:-1]
    words = [word for line in lines if (word := _line(line))]
    if words and not is_number(words[0]):
        words = words[1:]
    return bool(words) and all(is_number(w) and not float(w) % 1 for w in words)


def _line(line: bytes) -> str:
    return line.decode("utf-8", "replace").strip()


def _read_points(path: Path, options: ReadOptions) -> PointLabels:
    entry = format_by_name(path)
    if entry is None:
        raise BadInputError(f"{path.name}: expected a file of points with labels, got another")
    frame = next(iter(entry.read(path, options)), None)
    if frame is not None and frame.label is None and not options.chosen.columns:
        named = [name for name in frame.other if name.lower() in CLASSIFICATIONS]
        if named:
            chosen = Corrections(columns=(f"{named[0]}=label",))
            return _read_points(path, replace(options, chosen=chosen))
    if frame is None or frame.label is None:
        raise BadInputError(f"{path.name}: expected a field of labels, got none")
    if frame.dropped and frame.rows is None:
        raise BadInputError(
            f"{path.name}: expected all {len(frame) + frame.dropped} points to be valid, "
            f"{frame.dropped} are not, so that their order is not known"
        )
    instance = None if frame.instance is None else frame.instance.astype(np.int64)
    rows = None if own_palette(path) is None else frame.other.get(ROW)
    labels = PointLabels(path.name, frame.label.astype(np.int64), instance, rows)
    return labels if frame.rows is None else _of_rows(labels, frame.rows, frame.dropped)


def _of_rows(labels: PointLabels, rows: Numbers, dropped: int) -> PointLabels:
    """Spread labels over all rows of a file, 0 for rows without a point."""

    def spread(values: Numbers) -> Numbers:
        of_row = np.zeros(len(rows) + dropped, np.int64)
        of_row[rows] = values
        return of_row

    instance = None if labels.instance is None else spread(labels.instance)
    return replace(labels, category=spread(labels.category), instance=instance)


def _read_objects(path: Path, options: ReadOptions) -> PointLabels:
    """Read the points of objects of a room of S3DIS, from a folder or one file."""
    objects = read_objects(object_files(path) if path.is_dir() else [path], options)
    name = f"{path.parent.name}/{path.name}"
    return PointLabels(name, objects.category, objects.instance, xyz=objects.xyz)


def _read_classification(path: Path, options: ReadOptions) -> PointLabels:
    """Read the classification of LAS and LAZ; 0 and 1 mean unclassified."""
    labels = _read_points(
        path, replace(options, chosen=Corrections(columns=(f"{CLASSIFICATIONS[0]}=label",)))
    )
    return replace(labels, category=np.where(labels.category == 1, 0, labels.category))


READERS: Mapping[str, Callable[[Path, ReadOptions], PointLabels]] = MappingProxyType({
    "semantickitti": _read_semantic_kitti,
    "lidarseg": _read_octets,
    "panoptic": _read_panoptic,
    "labelcloud-points": _read_octets,
    "npy": _read_npy,
    "lines": _read_lines,
    "las": _read_classification,
    "s3dis": _read_objects,
    "points": _read_points,
})  # fmt: skip
"""Formats with one label for each point."""
