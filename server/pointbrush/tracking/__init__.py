"""Carrying labels through a recording: the paper's methods, ours, and others' by entry point."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.tracking.interface import (
        FrameKnowledge,
        FrameResult,
        Frames,
        Known,
        Method,
        Seed,
        TrackFrame,
        TrackOptions,
        TrackState,
    )
    from pointbrush.tracking.registry import METHODS

__all__ = [
    "METHODS",
    "FrameKnowledge",
    "FrameResult",
    "Frames",
    "Known",
    "Method",
    "Seed",
    "TrackFrame",
    "TrackOptions",
    "TrackState",
]
_PLACES = {
    "FrameKnowledge": "pointbrush.tracking.interface",
    "FrameResult": "pointbrush.tracking.interface",
    "Frames": "pointbrush.tracking.interface",
    "Known": "pointbrush.tracking.interface",
    "Method": "pointbrush.tracking.interface",
    "Seed": "pointbrush.tracking.interface",
    "TrackFrame": "pointbrush.tracking.interface",
    "TrackOptions": "pointbrush.tracking.interface",
    "TrackState": "pointbrush.tracking.interface",
    "METHODS": "pointbrush.tracking.registry",
}
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__, _PLACES)
