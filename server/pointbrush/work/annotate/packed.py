"""Values of many points in little memory."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

_LEVEL = 1  # zlib: the fastest; neighbours in stored order have the same label mostly


@dataclass(frozen=True, slots=True, eq=False)
class Packed:
    """Values of a run of points: compressed, or the one that all of them have."""

    count: int
    dtype: np.dtype[Any]
    data: bytes | None
    value: Any

    @classmethod
    def of(cls, values: NDArray[Any]) -> Packed:
        """Pack values (N,)."""
        same = not len(values) or bool((values == values[0]).all())
        data = None if same else zlib.compress(values.tobytes(), _LEVEL)
        return cls(len(values), values.dtype, data, values[0] if same and len(values) else 0)

    def values(self) -> NDArray[Any]:
        """The values (N,)."""
        if self.data is None:
            return np.full(self.count, self.value, self.dtype)
        return np.frombuffer(zlib.decompress(self.data), self.dtype)
