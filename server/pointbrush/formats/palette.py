"""Names and colours of labels that came with files: our own exports, and SemanticKITTI."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

NAME = "palette.json"
MAX_BYTES = 16 << 20
# A frame of SemanticKITTI lies three folders below the palette: sequences/00/velodyne.
LEVELS = 4
# Classes and colours of the SemanticKITTI benchmark (semantic-kitti.yaml); moving ones apart.
SEMANTIC_KITTI = {
    **{1: ("outlier", "#ff0000"), 10: ("car", "#6496f5"), 11: ("bicycle", "#64e6f5")},
    **{13: ("bus", "#6450fa"), 15: ("motorcycle", "#1e3c96"), 16: ("on-rails", "#0000ff")},
    **{18: ("truck", "#501eb4"), 20: ("other-vehicle", "#0000ff"), 30: ("person", "#ff1e1e")},
    **{31: ("bicyclist", "#ff28c8"), 32: ("motorcyclist", "#961e5a"), 40: ("road", "#ff00ff")},
    **{44: ("parking", "#ff96ff"), 48: ("sidewalk", "#4b004b"), 49: ("other-ground", "#af004b")},
    **{50: ("building", "#ffc800"), 51: ("fence", "#ff7832"), 52: ("other-structure", "#ff9600")},
    **{60: ("lane-marking", "#96ffaa"), 70: ("vegetation", "#00af00"), 71: ("trunk", "#873c00")},
    **{72: ("terrain", "#96f050"), 80: ("pole", "#fff096"), 81: ("traffic-sign", "#ff0000")},
    **{99: ("other-object", "#32ffff"), 252: ("moving-car", "#6496f5")},
    **{253: ("moving-bicyclist", "#ff28c8"), 254: ("moving-person", "#ff1e1e")},
    **{255: ("moving-motorcyclist", "#961e5a"), 256: ("moving-on-rails", "#0000ff")},
    **{257: ("moving-bus", "#6450fa"), 258: ("moving-truck", "#501eb4")},
    259: ("moving-other-vehicle", "#0000ff"),
}


@dataclass(frozen=True, slots=True)
class SourceLabel:
    """A label as its files name it; ``color`` is ``#rrggbb``."""

    id: int
    name: str
    category: str
    color: str


def source_palette(paths: Sequence[Path]) -> list[SourceLabel]:
    """The labels named by the ``palette.json`` of an export at or above ``paths``, or inside a zip.

    Else those of SemanticKITTI where ``.label`` files lie in its layout, else none.  A file that
    is no palette of ours names nothing: it may be anything.
    """
    for path in paths:
        text = _in_zip(path) if path.suffix.lower() == ".zip" else _beside(path)
        found = None if text is None else _parse(text)
        if found is not None:
            return found
    if any(_is_semantic_kitti(path) for path in paths):
        return [SourceLabel(i, name, name, color) for i, (name, color) in SEMANTIC_KITTI.items()]
    return []


def own_palette(file: Path) -> list[SourceLabel] | None:
    """The labels of the palette of ours that lies with a file; None where there is none."""
    text = _beside(file)
    return None if text is None else _parse(text)


def has_palette(file: Path) -> bool:
    """Whether a palette of ours lies with a file, so that label ids in it are ours."""
    return own_palette(file) is not None


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
        entries = json.loads(text)["labels"]
        labels = [_label(entry) for entry in entries]
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return labels if len({label.id for label in labels}) == len(labels) else None


def _label(entry: dict[str, Any]) -> SourceLabel:
    number, name, category, color = (entry[key] for key in ("id", "name", "category", "color"))
    texts = all(isinstance(text, str) and len(text) <= 200 for text in (name, category, color))
    if not isinstance(number, int) or not 1 <= number <= 65534 or not texts or not name:
        raise ValueError(entry)
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", color):
        raise ValueError(entry)
    return SourceLabel(number, name, category, color)


def _is_semantic_kitti(path: Path) -> bool:
    places = [path, path.parent] if path.is_dir() else list(path.parents)[:2]
    return any(
        (place / "velodyne").is_dir() and (place / "labels").is_dir()
        for place in (*places, *(path.glob("sequences/*") if path.is_dir() else ()))
    )
