"""Bounds of what is prepared and kept for the object tool."""

from __future__ import annotations

from dataclasses import dataclass, fields

from pointbrush.errors import BadInputError


@dataclass(frozen=True, slots=True)
class ObjectOptions:
    """Sizes and counts; all above 0."""

    memory_bytes: int = 512 * 2**20
    """States kept in memory, bytes on disk."""
    disk_bytes: int = 2 * 2**30
    """States kept on disk, of all recordings together, bytes."""
    ahead: int = 2
    """Frames on either side of the current one that are prepared after it."""
    waiting: int = 16
    """Frames that wait to be prepared; the oldest wish is dropped."""
    whole_points: int = 5_000_000
    """Points of the largest frame that is prepared whole; of larger ones what is near a click."""
    near_points: int = 150_000
    """Points of what is near a click, while the frame is not prepared."""
    near_reach: float = 8.0
    """Metres round a click that are near at most."""
    near_kept: int = 8
    """Surroundings of clicks that are kept prepared."""
    answers: int = 128
    """Candidates that are remembered."""
    clicks: int = 64
    """Positive clicks in a call, and negative ones."""

    def check(self) -> None:
        """Raise BadInputError for a number that is not above 0."""
        for each in fields(self):
            value = getattr(self, each.name)
            if not value > 0:
                raise BadInputError(f"{each.name}: expected a number above 0, got {value!r}")
