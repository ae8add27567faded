"""Class names by number, from files of tools and data sets.

YAML: ``labels`` and ``color_map`` (blue, green, red) of PRBonn/semantic-kitti-api, config/*.yaml.
XML: ``label`` elements of jbehley/point_labeler, assets/labels.xml.
JSON: ``classes`` of ch-sa/labelCloud, labels/_classes.json; rows of nuScenes' category.json.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from pointbrush.errors import BadInputError
from pointbrush.formats.options import read_bytes
from pointbrush.formats.tables.datasets import ClassName
from pointbrush.formats.tables.parsing import parse_json, parse_xml, parse_yaml
from pointbrush.names import spelled_out

GREATEST_CLASS = 65535
MOST_CLASSES = 4096
"""Most names in a column of labels; a column with more has no classes."""
MAP_BYTES = 4 << 20
YAML_BYTES = 1 << 18
"""Most bytes of a YAML file; the parser is slow."""
LONGEST_NAME = 200
NO_CLASS = ("unlabeled", "unlabelled", "unclassified", "undefined", "void", "none", "ignore")
"""Names that mean no class, also as the name of number 0."""
CLASS_FILES = {
    "lidarseg": "v1.0-*/category.json",
    "panoptic": "v1.0-*/category.json",
    "labelcloud-points": "_classes.json",
}
"""Files that state the classes of label files of a format, in a folder above these."""
CLASS_LEVELS = 4
_LINE = re.compile(r"\s*(\d+)\s*[:,;\s]\s*(\S.*?)\s*", re.ASCII)
_YAML_KEY = re.compile(r"^[A-Za-z_]\w*\s*:", re.MULTILINE)
_RGB_STATED = re.compile(r"^color_map\s*:.*\brgb\b", re.MULTILINE | re.IGNORECASE)


@dataclass(slots=True)
class ClassNumbers:
    """Numbers of classes that files give by name: the place in ``names``, from 1."""

    names: list[str] = field(default_factory=list)

    def number(self, where: str, name: str) -> int:
        """Return the number of a class, 0 for an empty name and for names of no class.

        Raises BadInputError naming ``where`` for a long text, or more texts than classes can be.
        """
        bare = spelled_out(name.strip())
        if not bare or bare.lower() in NO_CLASS:
            return 0
        if bare not in self.names:
            if len(bare) > LONGEST_NAME or len(self.names) >= MOST_CLASSES:
                raise BadInputError(
                    f"{where}: expected at most {MOST_CLASSES} class names of up to "
                    f"{LONGEST_NAME} characters as labels, got {bare[:40]!r} beyond"
                )
            self.names.append(bare)
        return self.names.index(bare) + 1


def read_map(path: Path) -> dict[int, ClassName]:
    """Read class names from a file; see ``parse_map``.  Raises NotFoundError, BadInputError."""
    if path.exists() and path.stat().st_size > MAP_BYTES:
        raise BadInputError(f"{path.name}: expected at most {MAP_BYTES} bytes")
    return parse_map(path.name, read_bytes(path).decode("utf-8-sig", "replace"))


def stated_classes(path: Path, format: str) -> dict[int, ClassName]:
    """Read the classes of a label file from the file of classes above it; {} without one.

    Raises BadInputError.
    """
    found = class_file(path, format)
    return {} if found is None else read_map(found)


def class_file(path: Path, format: str) -> Path | None:
    """Find the file of classes above a label file."""
    pattern = CLASS_FILES.get(format)
    above = path.absolute().parents[:CLASS_LEVELS] if pattern else ()
    return next((file for place in above for file in sorted(place.glob(str(pattern)))), None)


def parse_map(name: str, text: str) -> dict[int, ClassName]:
    """Parse class names from JSON ``{"10": "car"}`` or ``{"10": {"name": …, "color": …}}``, or as
    labelCloud and nuScenes have it, YAML with ``labels``, XML of point_labeler, or lines
    ``10 car`` or ``10: car``.

    Raises BadInputError naming ``name`` for other content.
    """
    start = text.lstrip()[:1]
    if start in ("{", "["):
        return _of_json(name, text)
    if start == "<":
        return _of_xml(name, text)
    if _YAML_KEY.search(text):
        return _of_yaml(name, text)
    return _of_lines(name, text)


def _of_json(name: str, text: str) -> dict[int, ClassName]:
    try:
        content = parse_json(text)
    except ValueError as error:
        raise BadInputError(f"{name}: expected JSON of numbers and names: {error}") from None
    if isinstance(content, dict) and not isinstance(content.get("classes"), list):
        return dict(_entry(name, key, value) for key, value in content.items())
    # 0 means unlabelled: labelCloud's default class, nuScenes' noise.
    rows, none = (
        (content["classes"], content.get("default")) if isinstance(content, dict) else (content, 0)
    )
    numbered = ((row.get("id", row.get("index")), row) for row in rows if isinstance(row, dict))
    return {
        number: _entry(name, str(number), row)[1]
        for number, row in numbered
        if number is not None and (number or none != 0)
    }


def _of_lines(name: str, text: str) -> dict[int, ClassName]:
    found = {}
    for number, line in enumerate(text.splitlines(), start=1):
        words = _LINE.fullmatch(line)
        if words is not None:
            key, value = _entry(name, words.group(1), words.group(2).strip("\"'"))
            found[key] = value
        elif line.strip() and not line.lstrip().startswith("#"):
            raise BadInputError(f"{name} line {number}: expected 'number name', got another line")
    return found


def _of_yaml(name: str, text: str) -> dict[int, ClassName]:
    if len(text) > YAML_BYTES:
        raise BadInputError(f"{name}: expected at most {YAML_BYTES} characters of YAML")
    try:
        content = parse_yaml(text)
    except ValueError as error:
        raise BadInputError(f"{name}: expected YAML of class names, got {error}") from None
    labels = content.get("labels") if isinstance(content, dict) else None
    if not isinstance(labels, dict):
        raise BadInputError(f"{name}: expected YAML with 'labels', numbers and names, got none")
    colors = content.get("color_map")
    order = 1 if _RGB_STATED.search(text) else -1
    return _classes(
        _entry(name, str(key), {"name": value, "color": _hex(name, colors, key, order)})
        for key, value in labels.items()
    )


def _classes(entries: Iterable[tuple[int, ClassName]]) -> dict[int, ClassName]:
    """Return classes by number, without number 0 if its name means no class."""
    found = dict(entries)
    if 0 in found and found[0].name.lower() in NO_CLASS:
        del found[0]
    return found


def _hex(name: str, colors: object, key: object, order: int) -> str:
    """Colour of a class as #rrggbb from its three numbers in a color_map, "" without one."""
    color = colors.get(key) if isinstance(colors, Mapping) else None
    if color is None:
        return ""
    if not isinstance(color, list) or len(color) != 3 or not all(_is_byte(c) for c in color):
        raise BadInputError(f"{name}: expected three numbers 0 to 255 as colour of {key}")
    return "#{:02x}{:02x}{:02x}".format(*color[::order])


def _is_byte(value: object) -> bool:
    return isinstance(value, int) and 0 <= value <= 255


def _of_xml(name: str, text: str) -> dict[int, ClassName]:
    try:
        root = parse_xml(text)
    except ValueError as error:
        raise BadInputError(f"{name}: expected XML of class names: {error}") from None
    found = _classes(_of_element(name, label) for label in root.iter("label"))
    if not found:
        raise BadInputError(f"{name}: expected XML with 'label' elements, got {root.tag!r}")
    return found


def _of_element(name: str, label: ElementTree.Element) -> tuple[int, ClassName]:
    key, called = (str(label.findtext(tag) or "").strip() for tag in ("id", "name"))
    words = (label.findtext("color") or "").split()
    try:
        color = _hex(name, {key: [int(word) for word in words]} if words else None, key, 1)
    except ValueError:
        raise BadInputError(f"{name}: expected three numbers as colour of {key}") from None
    return _entry(name, key, {"name": called, "color": color})


def _entry(name: str, key: str, value: object) -> tuple[int, ClassName]:
    text, color = value, ""
    if isinstance(value, dict):
        text, color = value.get("name"), str(value.get("color") or "")
    whole = key.isascii() and key.isdigit() and int(key[:9]) <= GREATEST_CLASS
    right = isinstance(text, str) and 0 < len(text.strip()) <= LONGEST_NAME
    if not whole or not right or not re.fullmatch("(#[0-9a-fA-F]{6})?", color):
        raise BadInputError(
            f"{name}: expected class numbers 0 to {GREATEST_CLASS} with names, got "
            f"{key[:40]!r}: {str(value)[:80]!r}"
        )
    return int(key), ClassName(str(text).strip(), color)
