"""Limits of preparation and caches of the object tool."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ObjectOptions:
    """Sizes and counts; all above 0."""

    memory_bytes: int = 512 * 2**20
    """Size of cached states in memory, by their bytes on disk."""
    disk_bytes: int = 2 * 2**30
    """Size of cached states on disk, for all recordings together, bytes."""
    ahead: int = 2
    """Number of frames on either side of the current one that are prepared after it."""
    waiting: int = 16
    """Limit of frames queued for preparation; the oldest is dropped."""
    whole_points: int = 5_000_000
    """Points of the largest frame that is prepared whole; for larger ones only around a click."""
    near_points: int = 150_000
    """Number of points around a click that are used while the frame is not prepared."""
    near_reach: float = 8.0
    """Largest distance of these points from the click, metres."""
    near_kept: int = 8
    """Limit of cached surroundings of clicks."""
    answers: int = 128
    """Limit of cached candidates."""
    clicks: int = 64
    """Limit of positive, and of negative, clicks in a call."""
