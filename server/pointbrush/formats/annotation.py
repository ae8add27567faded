"""Labels made elsewhere, one value a point: files of labels beside the points they are of.

Rows are in the order of the points' own file.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError, TooLargeError
from pointbrush.formats.box_labels import BOX_READERS, is_box_file
from pointbrush.formats.columns import without_marks
from pointbrush.formats.corrections import Corrections
from pointbrush.formats.datasets import LAS, NUSCENES, SEMANTIC_KITTI, ClassName, Dataset
from pointbrush.formats.names import LABEL_FORMATS
from pointbrush.formats.npy import require_array_header
from pointbrush.formats.nuscenes import label_times
from pointbrush.formats.options import Limits, ReadOptions, read_bytes, require_count
from pointbrush.formats.palette import SourceLabel, labels_of_packed, own_palette
from pointbrush.formats.registry import format_by_name
from pointbrush.formats.timing import in_order

Numbers = NDArray[np.int64]
PANOPTIC = 1000
"""nuScenes panoptic: a category's number times this, plus the instance's."""
GREATEST = 65535
LEVELS = 4
"""Folders below a path that are searched for label files."""
MAP_BYTES = 4 << 20
_DATASETS: Mapping[str, Dataset] = MappingProxyType({
    "semantickitti": SEMANTIC_KITTI, "lidarseg": NUSCENES, "panoptic": NUSCENES, "las": LAS,
})  # fmt: skip
"""Datasets whose numbers the labels of a format are."""
_LIKE_LABELS = re.compile("label|segm|class|semantic")


@dataclass(frozen=True, slots=True, eq=False)
class PointLabels:
    """Labels of one file's points: ``category`` (N,) class numbers, 0 for none unless the map names
    it; ``instance`` (N,) numbers or None."""

    file: str
    category: Numbers
    instance: Numbers | None


@dataclass(frozen=True, slots=True, eq=False)
class LabelFiles:
    """Label files in the order of frames: how each is read, and what their numbers are called.

    ``own``: labels by id, where a palette of ours lies with the files; their numbers are its ids.
    ``dataset`` is the one whose numbers they are, "" where it is not known.
    """

    format: str
    paths: tuple[Path, ...]
    names: Mapping[int, ClassName]
    own: Mapping[int, SourceLabel]
    dataset: str = ""

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
    files = [place] if place.is_file() else _files(place, limits)
    chosen, found = _choose(files, format)
    if not found:
        seen = ", ".join(sorted({path.suffix or path.name for path in files})[:8]) or "no files"
        raise BadInputError(
            f"{place.name}: expected files of labels ({', '.join(LABEL_FORMATS)}), got {seen}"
        )
    own = {label.id: label for label in own_palette(found[0]) or []}
    dataset = None if own else _DATASETS.get(chosen)
    return LabelFiles(
        chosen,
        tuple(in_order(found)),
        MappingProxyType({**(dataset.classes if dataset else {}), **names}),
        MappingProxyType(own),
        dataset.name if dataset else "",
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
    """The format, and its files: those that are labels and nothing else come first."""
    if format is not None:
        return format, [path for path in files if _fits(path, format)]
    for name in (each for each in LABEL_FORMATS if each != "las"):
        fitting = [path for path in files if _fits(path, name, sure=name != "points")]
        if fitting:
            return name, fitting
    return "points", []


def _fits(path: Path, format: str, *, sure: bool = False) -> bool:
    """Whether a file is of a format; ``sure``: its name leaves no doubt."""
    lower = path.name.lower()
    match format:
        case "semantickitti":
            return lower.endswith(".label")
        case "lidarseg":
            return lower.endswith("_lidarseg.bin" if sure else ".bin")
        case "panoptic":
            return lower.endswith("_panoptic.npz" if sure else ".npz")
        case "las":
            return lower.endswith((".las", ".laz"))
        case "npy":
            kept = path.parent.name not in ("provenance", "deleted")
            named = _LIKE_LABELS.search(f"{path.parent.name}/{lower}") is not None
            return lower.endswith(".npy") and kept and (named or not sure)
    if format in BOX_READERS:
        return is_box_file(path, format)
    return format_by_name(path) is not None


# ── readers ──────────────────────────────────────────────────────────────────────────────────


def _read_semantic_kitti(path: Path, options: ReadOptions) -> PointLabels:
    data = read_bytes(path)
    if len(data) % 4:
        raise BadInputError(f"{path.name}: expected labels of 4 bytes, got {len(data)} bytes")
    require_count(path.name, len(data) // 4, options.limits)
    raw = np.frombuffer(data, "<u4")
    own = own_palette(path)
    if own is not None:
        return PointLabels(path.name, labels_of_packed(path.name, raw, own).astype(np.int64), None)
    packed = raw.astype(np.int64)
    instance = packed >> 16
    return PointLabels(path.name, packed & 0xFFFF, instance if instance.any() else None)


def _read_lidarseg(path: Path, options: ReadOptions) -> PointLabels:
    data = read_bytes(path)
    require_count(path.name, len(data), options.limits)
    return PointLabels(path.name, np.frombuffer(data, np.uint8).astype(np.int64), None)


def _read_panoptic(path: Path, options: ReadOptions) -> PointLabels:
    require_array = ReadOptions(limits=options.limits)
    try:
        with np.load(path, allow_pickle=False) as stored:
            keys = stored.files
            packed = stored["data"] if "data" in keys else stored[keys[0]]
    except Exception as error:
        raise BadInputError(f"{path.name}: expected an array 'data': {error}") from None
    require_count(path.name, packed.size, require_array.limits)
    if packed.ndim != 1 or packed.dtype.kind not in "ui":
        raise BadInputError(
            f"{path.name}: expected (N,) whole numbers, got {packed.shape} {packed.dtype}"
        )
    numbers = packed.astype(np.int64)
    return PointLabels(path.name, numbers // PANOPTIC, numbers % PANOPTIC)


def _read_npy(path: Path, options: ReadOptions) -> PointLabels:
    require_array_header(path, options)
    array = np.load(path, allow_pickle=False, max_header_size=1 << 20)
    if array.ndim == 2 and 1 in array.shape:
        array = array.reshape(-1)
    if array.ndim != 1 or array.dtype.kind not in "ui":
        raise BadInputError(
            f"{path.name}: expected labels as (N,) whole numbers, got {array.shape} {array.dtype}"
        )
    return PointLabels(path.name, _numbers(path.name, array), None)


def _read_points(path: Path, options: ReadOptions) -> PointLabels:
    entry = format_by_name(path)
    if entry is None:
        raise BadInputError(f"{path.name}: expected a file of points with labels, got another")
    frame = next(iter(entry.read(path, options)), None)
    if frame is None or frame.label is None:
        raise BadInputError(f"{path.name}: expected a field of labels, got none")
    if frame.dropped and frame.rows is None:
        raise BadInputError(
            f"{path.name}: expected all {len(frame) + frame.dropped} points to be valid, "
            f"{frame.dropped} are not, so that their order is not known"
        )
    instance = None if frame.instance is None else frame.instance.astype(np.int64)
    if own_palette(path) is not None:
        instance = None  # a label of ours is an instance
    labels = PointLabels(path.name, frame.label.astype(np.int64), instance)
    return labels if frame.rows is None else _of_rows(labels, frame.rows, frame.dropped)


def _of_rows(labels: PointLabels, rows: Numbers, dropped: int) -> PointLabels:
    """Labels of all rows of a file, 0 for those that are no points."""

    def spread(values: Numbers) -> Numbers:
        of_row = np.zeros(len(rows) + dropped, np.int64)
        of_row[rows] = values
        return of_row

    instance = None if labels.instance is None else spread(labels.instance)
    return replace(labels, category=spread(labels.category), instance=instance)


def _numbers(name: str, values: NDArray[Any]) -> Numbers:
    numbers = without_marks(values).astype(np.int64)
    if len(numbers) and (numbers.min() < 0 or numbers.max() > GREATEST):
        raise BadInputError(
            f"{name}: expected labels 0 to {GREATEST}, got {numbers.min()} to {numbers.max()}"
        )
    return numbers


def _read_classification(path: Path, options: ReadOptions) -> PointLabels:
    """The classification of LAS and LAZ; 0 and 1 are points that nobody classified."""
    labels = _read_points(path, replace(options, chosen=Corrections(columns=(CLASSIFICATION,))))
    return replace(labels, category=np.where(labels.category == 1, 0, labels.category))


READERS: Mapping[str, Callable[[Path, ReadOptions], PointLabels]] = MappingProxyType({
    "semantickitti": _read_semantic_kitti,
    "lidarseg": _read_lidarseg,
    "panoptic": _read_panoptic,
    "npy": _read_npy,
    "las": _read_classification,
    "points": _read_points,
})  # fmt: skip
"""Formats of labels a point, those that are told by their names first."""
CLASSIFICATION = "classification=label"


# ── maps ─────────────────────────────────────────────────────────────────────────────────────


def read_map(path: Path) -> dict[int, ClassName]:
    """Read class names: JSON ``{"10": "car"}`` or ``{"10": {"name": …, "color": …}}``, or lines
    ``10 car`` or ``10: car``.

    Raises NotFoundError, BadInputError.
    """
    if path.exists() and path.stat().st_size > MAP_BYTES:
        raise BadInputError(f"{path.name}: expected at most {MAP_BYTES} bytes")
    return parse_map(path.name, read_bytes(path).decode("utf-8", "replace"))


def parse_map(name: str, text: str) -> dict[int, ClassName]:
    """The same from its text."""
    if text.lstrip().startswith("{"):
        try:
            content = json.loads(text)
        except ValueError as error:
            raise BadInputError(f"{name}: expected JSON of numbers and names: {error}") from None
        return dict(_entry(name, key, value) for key, value in content.items())
    found = {}
    for number, line in enumerate(text.splitlines(), start=1):
        words = re.fullmatch(r"\s*(\d+)\s*[:,;\s]\s*(\S.*?)\s*", line)
        if words is None:
            if not line.strip() or line.lstrip().startswith("#"):
                continue
            raise BadInputError(f"{name} line {number}: expected 'number name', got another line")
        key, value = _entry(name, words.group(1), words.group(2).strip("\"'"))
        found[key] = value
    return found


def _entry(name: str, key: str, value: object) -> tuple[int, ClassName]:
    text, color = value, ""
    if isinstance(value, dict):
        text, color = value.get("name"), str(value.get("color") or "")
    whole = key.isascii() and key.isdigit() and int(key[:9]) <= GREATEST
    right = isinstance(text, str) and 0 < len(text.strip()) <= 200
    if not whole or not right or not re.fullmatch("(#[0-9a-fA-F]{6})?", color):
        raise BadInputError(
            f"{name}: expected class numbers 0 to {GREATEST} with names, got "
            f"{str(key)[:40]!r}: {str(value)[:80]!r}"
        )
    return int(key), ClassName(str(text).strip(), color)


def frames_of(
    paths: Sequence[Path], frames: int, times: Sequence[float | None] = ()
) -> list[int | None]:
    """Return the frame that each file is of: one each in order, or by the numbers that name them.

    nuScenes' files named by tokens are of the frames of their times in the tables; ``times`` are
    those of the frames, seconds.  None for a file whose number or time is of no frame.
    """
    stamps = label_times(paths)
    if stamps:
        return _by_time([stamps[path] for path in paths], times, frames)
    if len(paths) == frames:
        return list(range(frames))
    found: list[int | None] = []
    for path in paths:
        digits = re.findall(r"\d+", path.stem)
        number = int(digits[-1][:9]) if digits else -1
        found.append(number if 0 <= number < frames else None)
    return found


def _by_time(stamps: list[float], times: Sequence[float | None], frames: int) -> list[int | None]:
    known = {round(t * 1e3): index for index, t in enumerate(times) if t is not None}
    if not known and len(stamps) == frames:
        ranks = np.argsort(np.argsort(stamps))
        return [int(rank) for rank in ranks]
    return [known.get(round(stamp * 1e3)) for stamp in stamps]
