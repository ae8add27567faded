"""Errors of pydantic in words, without importing it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def describe(found: Sequence[Any], most: int = 5) -> str:
    """Return Pydantic's errors as one line: place, expected value and received value of each.

    Errors of lists and objects that follow from errors of their items are left out.
    """
    outer = {tuple(item["loc"][:depth]) for item in found for depth in range(len(item["loc"]))}
    found = [item for item in found if tuple(item["loc"]) not in outer]
    lines = []
    for item in found[:most]:
        malformed = item["type"] == "json_invalid"
        place = item["loc"][:1] if malformed else item["loc"]
        where = ".".join(str(part) for part in place) or "message"
        lines.append(f"{where}: {_complaint(item)}{_got(item)}")
    more = len(found) - most
    return "; ".join(lines) + (f"; and {more} more" if more > 0 else "")


def _complaint(item: Any) -> str:
    """Return Pydantic's message in terms of JSON: dataclasses have keywords and tuples instead."""
    if item["type"] == "unexpected_keyword_argument":
        return "Extra inputs are not permitted"
    return str(item["msg"]).replace("Tuple ", "List ").replace("valid tuple", "valid list")


def _got(item: Any) -> str:
    """Describe the received value if it is known; for malformed JSON, the place and the error."""
    if item["type"] == "missing":
        return ""
    if item["type"] == "json_invalid":
        # FastAPI's message has neither place nor error; Pydantic's message has both.
        at = item["loc"][1:]
        return f" at character {at[0]}: {item['ctx']['error']}" if at else ""
    return f", got {str(item.get('input'))[:60]!r}"
