"""Our exports are what the makers' own readers read, and those read the boxes that we wrote."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from tests.box_readers import GOLDEN, READERS, content, example, files


@pytest.mark.parametrize("format", READERS)
def test_makers_read_the_boxes(format: str) -> None:
    read = json.loads((GOLDEN / f"{format}.json").read_text("utf-8"))["boxes"]
    wrote = [(frame.index, box) for frame in example(format) for box in frame.boxes]
    assert len(read) == len(wrote)
    for frame, box in wrote:
        (found,) = [r for r in read if (r["frame"], r["name"]) == (frame, box.name)]
        assert np.allclose(found["center"], box.center, atol=1e-3)
        assert np.allclose(found["size"], box.size, atol=1e-3)
        assert np.allclose(np.reshape(found["rotation"], (3, 3)), box.rotation, atol=1e-4)


@pytest.mark.parametrize("format", READERS)
def test_what_they_read_is_what_is_written(format: str) -> None:
    kept = json.loads((GOLDEN / f"{format}.json").read_text("utf-8"))["files"]
    made = {name: content(name, data) for name, data in files(format)}
    assert made.keys() == kept.keys()
    for name, value in made.items():
        require_alike(value, kept[name])


def require_alike(value: Any, other: Any) -> None:
    """Compare documents, numbers by a millionth."""
    if isinstance(value, dict):
        assert value.keys() == other.keys()
        for name, each in value.items():
            require_alike(each, other[name])
    elif isinstance(value, list):
        assert len(value) == len(other)
        for one, two in zip(value, other, strict=True):
            require_alike(one, two)
    elif isinstance(value, float) or (isinstance(value, str) and "." in value[:12]):
        assert _number(value) == pytest.approx(_number(other), abs=1e-6)
    else:
        assert value == other


def _number(value: Any) -> Any:
    try:
        return float(value)
    except ValueError:
        return value
