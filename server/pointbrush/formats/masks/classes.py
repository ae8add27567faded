"""Classes of masks by number and colour, from files beside them.

CVAT writes ``labelmap.txt`` with lines ``name:r,g,b:parts:actions``, CamVid ``label_colors.txt``
with lines ``r g b name``, LabelMe ``class_names.txt`` with a name a line, YOLO ``data.yaml`` with
``names``.  Other files are as in ``class_maps.parse_map``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pointbrush.errors import BadInputError
from pointbrush.formats.options import read_bytes
from pointbrush.formats.tables.class_maps import (
    CLASS_LEVELS,
    LONGEST_NAME,
    MAP_BYTES,
    NO_CLASS,
    YAML_BYTES,
    parse_map,
)
from pointbrush.formats.tables.datasets import ClassName
from pointbrush.formats.tables.parsing import parse_json, parse_yaml

NAMES = (
    *("labelmap.txt", "label_colors.txt", "class_names.txt", "classes.txt", "labels.txt"),
    *("obj.names", "data.yaml", "dataset.yaml", "classes.json", "labels.json"),
)
"""Names of files of classes, by precedence."""
BACKGROUND = (*NO_CLASS, "background", "ignored")
_COLORED = re.compile(r"([^:#]+):(\d{1,3}),(\d{1,3}),(\d{1,3}):[^:]*:[^:]*")
_CAMVID = re.compile(r"(\d{1,3})\s+(\d{1,3})\s+(\d{1,3})\s+(\S.*)", re.ASCII)
_NUMBERED = re.compile(r"\d+\s*[:,;\s]\s*\S.*", re.ASCII)


@dataclass(frozen=True, slots=True)
class MaskClasses:
    """``names`` of classes by number; ``colors``: numbers by colour 0xrrggbb, None for no class.

    ``file``: name of the file that states them, "" without one; ``by_color``: the file has colours
    and no numbers, so that the colours of a palette identify the classes, not its indices.
    """

    file: str = ""
    names: Mapping[int, ClassName] = field(default_factory=dict)
    colors: Mapping[int, int | None] = field(default_factory=dict)
    by_color: bool = False


def classes_file(mask: Path) -> Path | None:
    """Return the file of classes beside a mask or in a folder above it."""
    above = mask.absolute().parents[: CLASS_LEVELS + 1]
    paths = (folder / name for folder in above for name in NAMES)
    return next((path for path in paths if path.is_file()), None)


def read_classes(mask: Path, *, counted_from: int | None = None) -> MaskClasses:
    """Return the classes of a mask from the file beside it or above; none without such a file.

    ``counted_from``: number of the first name in a file without numbers; None: 0 if this name
    means no class, otherwise 1.  Raises BadInputError.
    """
    path = classes_file(mask)
    if path is None:
        return MaskClasses()
    if (size := path.stat().st_size) > MAP_BYTES:
        raise BadInputError(f"{path.name}: expected at most {MAP_BYTES:,} bytes, got {size:,}")
    text = read_bytes(path).decode("utf-8-sig", "replace")
    if path.suffix in (".json", ".yaml"):
        return _of_document(path.name, text, counted_from)
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    for pattern, order in ((_COLORED, (0, 1, 2, 3)), (_CAMVID, (3, 0, 1, 2))):
        matches = [pattern.fullmatch(line) for line in lines]
        if lines and all(matches):
            rows = [[each.group(k + 1) for k in order] for each in matches if each]
            return _of_colors(path.name, rows)
    if lines and all(map(_NUMBERED.fullmatch, lines)):
        return _of_numbers(path.name, parse_map(path.name, text))
    return _of_names(path.name, lines, counted_from)


def _of_colors(file: str, rows: Iterable[Sequence[str]]) -> MaskClasses:
    names: dict[int, ClassName] = {}
    colors: dict[int, int | None] = {}
    for number, (name, *channels) in enumerate(rows):
        red, green, blue = map(int, channels)
        color = red << 16 | green << 8 | blue
        if max(red, green, blue) > 255:
            raise BadInputError(f"{file}: expected colours 0 to 255, got {channels} of {name!r}")
        colors[color] = None if _is_background(name) else number
        if not _is_background(name):
            names[number] = ClassName(name.strip()[:LONGEST_NAME], f"#{color:06x}")
    return MaskClasses(file, names, colors, by_color=True)


def _of_numbers(file: str, names: Mapping[int, ClassName]) -> MaskClasses:
    """Return classes by number, which may have colours."""
    kept = {number: name for number, name in names.items() if not _is_background(name.name)}
    colors = {int(n.color[1:], 16): k if k in kept else None for k, n in names.items() if n.color}
    return MaskClasses(file, kept, colors)


def _of_names(file: str, names: Sequence[Any], counted_from: int | None) -> MaskClasses:
    if not all(isinstance(name, str) and 0 < len(name.strip()) <= LONGEST_NAME for name in names):
        raise BadInputError(f"{file}: expected names of up to {LONGEST_NAME} characters")
    first = counted_from
    if first is None:
        first = 0 if names and _is_background(names[0]) else 1
    numbered = enumerate(map(str.strip, names), start=first)
    return _of_numbers(file, {number: ClassName(name) for number, name in numbered})


def _of_document(file: str, text: str, counted_from: int | None) -> MaskClasses:
    """Return the classes of YOLO's ``names``, a list of names, names with numbers, or a map."""
    content = _parsed(file, text)
    keys = ("names", "classes", "categories")
    inside = isinstance(content, dict) and next((content[k] for k in keys if k in content), None)
    names = inside or content
    if isinstance(names, list) and all(isinstance(each, str) for each in names):
        return _of_names(file, names, counted_from)
    pairs = [*names.items()] if isinstance(names, dict) else []
    if pairs and all(type(value) is int for _, value in pairs):
        pairs = [(number, name) for name, number in pairs]
    if pairs and all(isinstance(name, str) for _, name in pairs):
        text = "\n".join(f"{number} {name}" for number, name in pairs)
    return _of_numbers(file, parse_map(file, text))


def _parsed(file: str, text: str) -> Any:
    try:
        if file.endswith(".json"):
            return parse_json(text)
        if len(text) <= YAML_BYTES:
            return parse_yaml(text)
        reason = f"more than {YAML_BYTES:,} characters"
    except ValueError as error:
        reason = str(error)
    raise BadInputError(f"{file}: expected names of classes: {reason}")


def _is_background(name: str) -> bool:
    """Return whether a name means pixels that belong to no class."""
    return name.strip().strip("_").lower() in BACKGROUND
