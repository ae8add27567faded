"""Where a sensor was in each frame, found frame by frame when it is asked for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from pointbrush.tracking.interface import F64, Frames, TrackFrame


class Trajectory(ABC):
    """``T_world_frame`` of each frame of ``order``; the world is the first frame."""

    def __init__(self, frames: Frames, order: Sequence[int]) -> None:
        self._frames, self._order = frames, list(order)
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
