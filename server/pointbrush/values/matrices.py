"""Matrices in values: arrays in Python, numbers in JSON."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.values.base import Rule, Schema
from pointbrush.values.kinds import FARTHEST

Floats = NDArray[np.float64]
NUMBER: Schema = {"type": "float", "ge": -FARTHEST, "le": FARTHEST, "allow_inf_nan": False}


class _Array(Rule):
    """An array, which JSON has as ``json_schema``; ``flat``: row by row without nesting."""

    def __init__(self, json_schema: Schema, *, flat: bool) -> None:
        super().__init__()
        self._schema, self._flat = json_schema, flat

    def _read(self, numbers: Any) -> Floats:
        array = np.asarray(numbers, np.float64)
        return array.reshape(4, 4) if self._flat else array

    def _write(self, array: Any) -> list[Any]:
        found: list[Any] = (np.ravel(array) if self._flat else np.asarray(array)).tolist()
        return found

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Schema:
        return {
            "type": "function-after",
            "function": {"type": "no-info", "function": self._read},
            "schema": self._schema,
            "serialization": {
                "type": "function-plain",
                "function": self._write,
                "return_schema": self._schema,
            },
        }


ROWS: Schema = {
    "type": "list",
    "items_schema": {"type": "list", "items_schema": {"type": "float"}},
}
SIXTEEN: Schema = {"type": "list", "items_schema": NUMBER, "min_length": 16, "max_length": 16}
Rows = Annotated[Floats, _Array(ROWS, flat=False)]
"""A matrix; a list of its rows in JSON."""
Pose = Annotated[Floats, _Array(SIXTEEN, flat=True)]
"""A transform (4, 4); its 16 numbers row by row in JSON."""
