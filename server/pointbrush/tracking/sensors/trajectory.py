"""Trajectory of a sensor: recorded, or registered frame by frame on demand."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Literal

import numpy as np

from pointbrush.tracking.interface import F64, Frames, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.sensors import ScanOdometryOptions

Motion = Literal["moves", "rests", "unclear"]
"""Motion of a sensor between two frames."""


class Trajectory(ABC):
    """``T_world_frame`` of each frame; the world is the first frame of a run.

    ``lost``: frames with too little scene for a registration, which keep the last pose.
    """

    def __init__(self) -> None:
        self.lost: set[int] = set()

    @abstractmethod
    def pose(self, number: int) -> F64:
        """Return the pose (4, 4) of frame ``number``."""

    def over(self, _some: Sequence[int]) -> Trajectory:
        """Return a trajectory that computes only some frames, starting with the run's first."""
        return self


class RecordedTrajectory(Trajectory):
    """A recorded trajectory."""

    def __init__(self, frames: Frames, back: F64, options: TrackerOptions) -> None:
        """``back`` (4, 4): from the recording's coordinates to the world."""
        super().__init__()
        self._frames, self._back, self.options = frames, back, options

    def pose(self, number: int) -> F64:
        """See ``Trajectory``."""
        pose = recorded_pose(self._frames(number), options=self.options.scan_odometry)
        return np.eye(4) if pose is None else np.asarray(self._back @ pose, np.float64)


def recorded_pose(frame: TrackFrame, options: ScanOdometryOptions) -> F64 | None:
    """Return the recorded pose of a frame; None: it is not a rigid motion."""
    pose = frame.pose
    if pose is None or abs(float(np.linalg.det(pose[:3, :3])) - 1.0) > options.max_skew:
        return None
    return pose


class RegisteredTrajectory(Trajectory):
    """A trajectory over the frames ``order``, each registered to earlier ones."""

    def __init__(self, frames: Frames, order: Sequence[int], options: TrackerOptions) -> None:
        super().__init__()
        self._frames, self._order, self.options = frames, list(order), options
        self._poses = [np.eye(4)]

    def pose(self, number: int) -> F64:
        """Return the pose of frame ``number``; earlier frames are registered first."""
        at = self._order.index(number)
        while len(self._poses) <= at:
            frame = self._frames(self._order[len(self._poses)])
            self._poses.append(self._registered(frame))
        return self._poses[at]

    @abstractmethod
    def _registered(self, frame: TrackFrame) -> F64:
        """Return the pose of the ``frame`` after the last registered one."""
