"""Frames in which the tracker is not sure of a label."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

DOUBTFUL = 0.5
"""Confidence under which a tracked frame should be looked at."""


def is_doubtful(track: Mapping[str, Any]) -> bool:
    """Tell whether a label was lost, occluded or tracked with little confidence in a frame."""
    return track["state"] in ("lost", "occluded") or track["confidence"] < DOUBTFUL
