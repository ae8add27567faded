"""Carrying labels through a recording: the paper's methods, ours, and others' by entry point."""

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
