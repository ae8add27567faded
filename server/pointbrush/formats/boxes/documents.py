"""JSON documents of boxes and the numbers in them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.options import read_bytes
from pointbrush.formats.tables.parsing import parse_json


def document(path: Path) -> Any:
    """Read a JSON document.  Raises ValueError for other files."""
    return parse_json(read_bytes(path).decode("utf-8-sig"))


def lines_of_words(path: Path, least: int, most: int | None = None) -> Iterator[list[str]]:
    """Split the lines of a text, except empty ones, into ``least`` to ``most`` words each.

    Raises BadInputError for other numbers of words.
    """
    for number, line in enumerate(read_bytes(path).decode("utf-8", "replace").splitlines(), 1):
        words = line.split()
        if words and not least <= len(words) <= (most or len(words)):
            raise BadInputError(
                f"{path.name} line {number}: expected {least} values, got {len(words)}"
            )
        if words:
            yield words


def vector(values: Any, keys: Iterable[Any] = "xyz") -> NDArray[np.float64]:
    """Read finite numbers of an object or a list by their keys.  Raises ValueError, KeyError."""
    found = np.array([float(values[key]) for key in keys])
    if not np.isfinite(found).all():
        raise ValueError(values)
    return found
