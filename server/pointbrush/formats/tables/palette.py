"""Names and colours of labels stored with files: our own exports, and SemanticKITTI."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.datasets import SEMANTIC_KITTI
from pointbrush.formats.tables.parsing import parse_json
from pointbrush.names import spelled_out

NAME = "palette.json"
MAX_BYTES = 16 << 20
# A frame of SemanticKITTI lies three folders below the palette: sequences/00/velodyne.
LEVELS = 4


@dataclass(frozen=True, slots=True)
class SourceLabel:
    """A label of a file's palette; ``color`` is ``#rrggbb``.

    ``packed``: the label's number in a SemanticKITTI export, class and instance, if it has one;
    ``instance``: its number in the source, None without a source.
    """

    id: int
    name: str
    category: str
    color: str
    packed: int | None = None
    instance: int | None = None

    def __post_init__(self) -> None:
        """Write out characters that names must not contain."""
        for field in ("name", "category"):
            object.__setattr__(self, field, spelled_out(getattr(self, field)))


def labels_of_packed(
    name: str, packed: NDArray[np.uint32], palette: Sequence[SourceLabel]
) -> NDArray[np.uint16]:
    """Return the ids of labels by their numbers (n,) in a SemanticKITTI export of pointbrush.

    Points with a class only may have an instance of their source.  Older exports have the label's
    id in the upper 16 bits.  Raises BadInputError for an unknown number.
    """
    if all(label.packed is None for label in palette):
        return (packed >> 16).astype(np.uint16)
    by_number = {label.packed: label.id for label in palette} | {0: 0}
    numbers, place = np.unique(packed, return_inverse=True)
    ids = []
    for number in numbers.tolist():
        found = by_number.get(number, by_number.get(number & 0xFFFF))
        if found is None:
            raise BadInputError(
                f"{name}: expected the classes and instances of {NAME}, got class "
                f"{number & 0xFFFF} and instance {number >> 16}"
            )
        ids.append(found)
    return np.array(ids, np.uint16)[place]


def own_labels(paths: Sequence[Path]) -> list[SourceLabel]:
    """Return the labels of the ``palette.json`` of an export at or above ``paths``, or in a zip.

    A file that is not a palette of pointbrush has no labels.
    """
    for path in paths:
        text = _in_zip(path) if path.suffix.lower() == ".zip" else _beside(path)
        found = None if text is None else _parse(text)
        if found is not None:
            return found
    return []


def own_palette(file: Path) -> list[SourceLabel] | None:
    """Return the labels of the pointbrush palette beside a file, or None without one."""
    text = _beside(file)
    return None if text is None else _parse(text)


def _beside(path: Path) -> bytes | None:
    absolute = path.absolute()
    folders = ([absolute] if path.is_dir() else []) + list(absolute.parents)[:LEVELS]
    candidates = [absolute.with_name(f"{path.stem}.{NAME}"), *(f / NAME for f in folders)]
    for candidate in candidates:
        try:
            if candidate.is_file() and candidate.stat().st_size <= MAX_BYTES:
                return candidate.read_bytes()
        except OSError:
            continue
    return None


def _in_zip(path: Path) -> bytes | None:
    try:
        with zipfile.ZipFile(path) as archive:
            for entry in archive.infolist():
                if Path(entry.filename).name == NAME and entry.file_size <= MAX_BYTES:
                    return archive.read(entry)
    except (OSError, ValueError, RuntimeError, zipfile.BadZipFile):
        return None
    return None


def _parse(text: bytes) -> list[SourceLabel] | None:
    try:
        entries = parse_json(text)["labels"]
        labels = [_label(entry) for entry in entries]
    except (ValueError, KeyError, TypeError, AttributeError):
        return None
    return labels if len({label.id for label in labels}) == len(labels) else None


def _label(entry: dict[str, Any]) -> SourceLabel:
    number, name, category, color = (entry[key] for key in ("id", "name", "category", "color"))
    texts = all(isinstance(text, str) and len(text) <= 256 for text in (name, category, color))
    if not isinstance(number, int) or not 1 <= number <= 65534 or not texts or not name:
        raise ValueError(entry)
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", color):
        raise ValueError(entry)
    packed = entry.get("datasets", {}).get(SEMANTIC_KITTI.name)
    if packed is not None:
        kind, instance = packed
        if not (0 <= kind <= 65535 and 0 <= instance <= 65535):
            raise ValueError(entry)
        packed = kind | instance << 16
    came = entry.get("source_instance")
    if came is not None and not (isinstance(came, int) and 0 <= came <= 65535):
        raise ValueError(entry)
    if entry.get("categoryless") is True:
        category = ""
    return SourceLabel(number, name, category, color, packed, came)
