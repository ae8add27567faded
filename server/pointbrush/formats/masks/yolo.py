"""Masks in YOLO's text of segments: lines ``class x y x y …`` in shares of width and height."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.masks.classes import NAMES, classes_file, read_classes
from pointbrush.formats.masks.mask import Mask, MaskDrawing, MaskFile, Size, require_size
from pointbrush.formats.masks.polygons import fill_polygon
from pointbrush.formats.options import read_bytes
from pointbrush.formats.tables.class_maps import GREATEST_CLASS
from pointbrush.formats.tables.datasets import ClassName

HEAD = 1 << 14
"""Bytes of a text that are checked for polygons."""
MARGIN = 0.01
"""Most distance of a corner from the picture, as some tools write it, as a share of its size."""


def is_yolo(path: Path, *, sure: bool) -> bool:
    """Return whether a text's first line is a polygon.

    ``sure``: only if a file beside the text or above it names the classes.
    """
    if path.suffix.lower() != ".txt" or path.name in NAMES or (sure and not classes_file(path)):
        return False
    with path.open("rb") as file:
        line = file.read(HEAD).strip().split(b"\n")[0].decode("utf-8", "replace")
    try:
        _polygon(line)
    except ValueError:
        return False
    return True


def read_yolo(
    paths: Mapping[Path, str], names: Mapping[int, ClassName]
) -> tuple[list[MaskFile], dict[int, ClassName]]:
    """Return the masks of texts, and their classes by number from 0.

    ``paths``: names of the texts; ``names``: names of classes from the caller.
    """
    classes = {**read_classes(next(iter(paths)), counted_from=0).names, **names}
    return [MaskFile(name, partial(_read, path)) for path, name in paths.items()], classes


def _read(path: Path, size: Size) -> Mask:
    """Return the mask of a picture: the polygons of a text, each drawn over the ones before."""
    require_size(path.name, size, size)
    drawing = MaskDrawing(size)
    for number, line in enumerate(read_bytes(path).decode("utf-8", "replace").splitlines(), 1):
        if line.strip():
            try:
                kind, corners = _polygon(line)
                shape = np.zeros(size[::-1], np.bool_)
                fill_polygon(shape, corners * size)
                drawing.draw(shape, (kind, -number))
            except ValueError as error:
                raise BadInputError(
                    f"{path.name} line {number}: expected a class and the corners of a polygon "
                    f"from 0 to 1, got {error}"
                ) from None
    return drawing.mask()


def _polygon(line: str) -> tuple[int, NDArray[np.float64]]:
    """Return the class and the corners (n, 2), 0 to 1, of a line; raises ValueError."""
    kind, *words = line.split()
    if len(words) == 4:
        raise ValueError("a box, which has no mask")
    corners = np.array(words, np.float64)
    if len(words) < 6 or len(words) % 2:
        raise ValueError(f"{len(words)} numbers")
    if not (kind.isascii() and kind.isdigit() and int(kind[:9]) <= GREATEST_CLASS):
        raise ValueError(f"class {kind[:20]!r}")
    if not ((corners >= -MARGIN) & (corners <= 1 + MARGIN)).all():
        raise ValueError("corners outside of the picture")
    return int(kind), corners.reshape(-1, 2)
