"""JSON documents of boxes and the numbers in them."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.options import read_bytes


def document(path: Path) -> Any:
    """Read a JSON document.  Raises ValueError for other files."""
    return json.loads(read_bytes(path).decode("utf-8-sig"))


def vector(values: Any, keys: Iterable[Any] = "xyz") -> NDArray[np.float64]:
    """Read finite numbers of an object or a list by their keys.  Raises ValueError, KeyError."""
    found = np.array([float(values[key]) for key in keys])
    if not np.isfinite(found).all():
        raise ValueError(values)
    return found
