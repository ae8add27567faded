"""Names and colours for a new label that no other label has."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from itertools import count
from typing import Any

from pointbrush.labels.palette import HIGHEST, NAME_LIMIT, default_color
from pointbrush.labels.types import Label

_NUMBERED = re.compile(r"(.*?)\s*(\d{0,9})", re.DOTALL)


def free_name_and_color(fields: Mapping[str, Any], others: Collection[Label]) -> dict[str, Any]:
    """Return ``name`` and ``color`` of ``fields``, changed where one of ``others`` has them."""
    names = {label.name.strip().casefold() for label in others}
    colors = {label.color for label in others}
    return {
        "name": _free_name(fields["name"], names),
        "color": _free_color(fields["color"], colors),
    }


def _free_name(name: str, taken: Collection[str]) -> str:
    """Return ``name``, or with its number counted on: "pin 2" for "pin" or "pin 1"."""
    if name.strip().casefold() not in taken:
        return name
    numbered = _NUMBERED.fullmatch(name.strip())
    base, digits = numbered.groups() if numbered else (name, "")
    for number in count(int(digits or 1) + 1):
        end = f" {number}" if base else str(number)
        found = base[: NAME_LIMIT - len(end)] + end
        if found.casefold() not in taken:
            return found
    raise AssertionError("numbers do not end")


def _free_color(color: str, taken: Collection[str]) -> str:
    """Return ``color``, or the first of the palette's own that is not taken."""
    if color not in taken:
        return color
    return next(
        (found for i in range(1, HIGHEST) if (found := default_color(i)) not in taken), color
    )
