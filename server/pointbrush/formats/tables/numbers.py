"""Numbers in text, at NumPy's speed."""

from __future__ import annotations

import re
import warnings

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError

_WINDOWS = re.compile(
    rb"(?<!\S)([-+]?)(?:1\.#(IND|QNAN|SNAN|INF)\d*|nan\((?:s?nan|ind|q?nan)\))(?!\S)", re.I
)


def parse_numbers(name: str, text: bytes) -> NDArray[np.float64]:
    """Return all whitespace-separated numbers; raise BadInputError naming the first invalid one.

    ``1.#IND``, ``1.#QNAN``, ``1.#INF``: NaN and infinity of older programs for Windows.
    """
    found = _parsed(text)
    if found is None and (b"#" in text or b"(" in text):
        found = _parsed(_WINDOWS.sub(_usual, text))
    if found is not None:
        return found
    for line_number, line in enumerate(text.splitlines(), start=1):
        for word in line.split():
            if not is_number(word.decode("utf-8", "replace")):
                raise BadInputError(
                    f"{name}: expected numbers, got another word in data line {line_number}"
                )
    raise BadInputError(f"{name}: expected numbers, got text that is none")


def _parsed(text: bytes) -> NDArray[np.float64] | None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)
            return np.fromstring(text, dtype=np.float64, sep=" ")
    except (ValueError, DeprecationWarning):
        return None


def _usual(match: re.Match[bytes]) -> bytes:
    infinite = (match.group(2) or b"").upper() == b"INF"
    return match.group(1) + b"inf" if infinite else b"nan"


def is_number(word: str) -> bool:
    """Return whether a word is a number, also as older programs for Windows write it."""
    try:
        float(word)
    except ValueError:
        return _WINDOWS.fullmatch(word.encode()) is not None
    return True
