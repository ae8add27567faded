"""Alignment of the sensors of a recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pointbrush.values.base import Body, Rule, Value
from pointbrush.values.kinds import FrameIndex, Uuid


@dataclass(frozen=True, slots=True)
class SensorAlignment(Body):
    """Frames by which to align the sensors of a recording."""

    frames: Annotated[tuple[FrameIndex, ...], Rule(min_length=1, max_length=100)] | None = None
    """Numbers of the frames; null: some of the whole recording."""
    undo: bool = False
    """Restore the mounts of before the last alignment; a second undo takes it again."""
    id: Uuid | None = None
    """UUID of the job; a repeated call does not start another job."""


@dataclass(frozen=True, slots=True)
class AlignedSensor(Value):
    """Correction of a sensor's mount; the first sensor stays where it is."""

    name: str
    """Its name."""
    before: float
    """Median distance of its points from surfaces that other sensors see, before, metres."""
    after: float
    """The same with the correction, metres."""
    shift: float
    """Distance by which the sensor was moved, metres."""
    turn: float
    """Angle by which it was turned, degrees."""
    pairs: int
    """Number of points of which the distance was measured."""


@dataclass(frozen=True, slots=True)
class AlignedSensors(Value):
    """Result of a job that aligns sensors."""

    sensors: tuple[AlignedSensor, ...]
    """The sensors in their order; empty after an undo."""
    message: str
    """Sentence about the result."""
