"""Trajectory of a sensor: as a recording tells it, or found frame by frame when asked."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Literal

import numpy as np

from pointbrush.tracking.interface import F64, Frames, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.sensors import ScanOdometryOptions

Motion = Literal["moves", "rests", "unclear"]
"""Motion of a sensor between two frames, as far as they show it."""


class Trajectory(ABC):
    """``T_world_frame`` of each frame; the world is the first frame of a run.

    ``lost`` frames that showed too little to tell, and are taken to be where the last one was.
    """

    def __init__(self) -> None:
        self.lost: set[int] = set()

    @abstractmethod
    def pose(self, number: int) -> F64:
        """The pose (4, 4) of frame ``number``."""

    def over(self, _some: Sequence[int]) -> Trajectory:
        """The way over some frames, the first of them that of the run, at their cost alone."""
        return self


class RecordedTrajectory(Trajectory):
    """A way that the recording tells."""

    def __init__(self, frames: Frames, back: F64, options: TrackerOptions) -> None:
        """``back`` (4, 4) from where the recording counts to the world."""
        super().__init__()
        self._frames, self._back, self.options = frames, back, options

    def pose(self, number: int) -> F64:
        """See ``Trajectory``."""
        pose = recorded_pose(self._frames(number), options=self.options.scan_odometry)
        return np.eye(4) if pose is None else np.asarray(self._back @ pose, np.float64)


def recorded_pose(frame: TrackFrame, options: ScanOdometryOptions) -> F64 | None:
    """The pose of a frame as the recording tells it, None where that is no motion of space."""
    pose = frame.pose
    if pose is None or abs(float(np.linalg.det(pose[:3, :3])) - 1.0) > options.max_skew:
        return None
    return pose


class RegisteredTrajectory(Trajectory):
    """A way that the frames ``order`` show, each registered to those before it."""

    def __init__(self, frames: Frames, order: Sequence[int], options: TrackerOptions) -> None:
        super().__init__()
        self._frames, self._order, self.options = frames, list(order), options
        self._poses = [np.eye(4)]

    def pose(self, number: int) -> F64:
        """The pose of frame ``number``; frames before it are registered first."""
        at = self._order.index(number)
        while len(self._poses) <= at:
            here = self._frames(self._order[len(self._poses)])
            self._poses.append(self._registered(here))
        return self._poses[at]

    @abstractmethod
    def _registered(self, frame: TrackFrame) -> F64:
        """The pose of the ``frame`` that follows those whose poses are known."""
