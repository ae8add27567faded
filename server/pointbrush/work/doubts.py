"""Frames with an uncertain track of a label."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

DOUBTFUL = 0.5
"""Confidence below which a tracked frame needs a review."""


def is_doubtful(track: Mapping[str, Any]) -> bool:
    """Return whether a label was lost, occluded or tracked with low confidence in a frame."""
    return track["state"] in ("lost", "occluded") or track["confidence"] < DOUBTFUL
