"""JSON of files from elsewhere, whose errors are ValueErrors, whatever they hold."""

from __future__ import annotations

import json
from typing import Any

GREATEST = 2.0**63


def parse_json(data: str | bytes) -> Any:
    """Parse JSON; a whole number of more than 64 bits becomes a float.

    Raises ValueError, also for text that is nested too deeply.
    """
    try:
        return json.loads(data, parse_int=_whole)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def _whole(digits: str) -> int | float:
    number = float(digits)
    return int(digits) if abs(number) < GREATEST else number
