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
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)
