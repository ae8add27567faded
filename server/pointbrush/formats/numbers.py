"""Numbers in text, at NumPy's speed."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError


def parse_numbers(name: str, text: bytes) -> NDArray[np.float64]:
    """All whitespace-separated numbers; raises BadInputError naming the first that is none."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)
            return np.fromstring(text, dtype=np.float64, sep=" ")
    except (ValueError, DeprecationWarning):
        for line_number, line in enumerate(text.splitlines(), start=1):
            for word in line.split():
                try:
                    float(word)
                except ValueError:
                    raise BadInputError(
                        f"{name}: expected numbers, got another word in data line {line_number}"
                    ) from None
        raise BadInputError(f"{name}: expected numbers, got text that is none") from None
