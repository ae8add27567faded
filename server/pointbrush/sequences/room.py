"""The room: the placement of a recording around a person."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.floor import Kind, find_floor

_KEEP = 12
_ROOM_SIZE = 30.0
"""Recordings wider than this (metres) are entered where the sensor was, not in their middle."""


def axis_of(name: str) -> NDArray[np.float64]:
    """The unit vector (3,) of an axis called "x", "-x", … "-z"."""
    axis = np.zeros(3)
    axis["xyz".index(name[-1])] = -1.0 if name.startswith("-") else 1.0
    return axis


def nearest_axis(direction: NDArray[np.float64]) -> str:
    """The axis, "x", "-x", … "-z", that is nearest to a direction (3,)."""
    largest = int(np.abs(direction).argmax())
    return "-" * bool(direction[largest] < 0) + "xyz"[largest]


class RoomFinder:
    """Collects samples of a recording's frames, however long it is, and places the room."""

    def __init__(self, shift: NDArray[np.float64], up: str | None = None) -> None:
        """``shift``: local = source − shift; ``up``: the up axis that a user gave, or None."""
        self._shift = shift
        self._up = None if up is None else axis_of(up)
        self._points: list[NDArray[np.float32]] = []
        self._viewpoints: list[NDArray[np.float64]] = []
        self._stride = 1
        self._seen = 0

    def add(self, prefix: NDArray[np.float32], viewpoint: NDArray[np.float64] | None) -> None:
        """Add an even subsample (n, 3) of a frame, local, and its sensor position in the source."""
        if self._seen % self._stride == 0 and len(prefix):
            self._points.append(prefix)
            if len(self._points) > _KEEP:
                del self._points[1::2]
                self._stride *= 2
        if viewpoint is not None and len(self._viewpoints) < _KEEP:
            self._viewpoints.append(viewpoint - self._shift)
        self._seen += 1

    def room(self, *, camera: bool) -> NDArray[np.float64]:
        """``T_room_local`` (4, 4): floor at y = 0, y up, -z ahead, the middle at the origin."""
        points = np.concatenate([np.empty((0, 3)), *self._points]).astype(np.float64)
        viewpoints = np.array(self._viewpoints).reshape(-1, 3)
        # Coordinates far from the origin are map coordinates, which have z up.
        kind: Kind = "camera" if camera else "survey" if self._shift.any() else "unknown"
        floor = find_floor(points, viewpoints, kind, self._up)
        right = np.cross(floor.forward, floor.up)
        rotation = np.stack([right, floor.up, -floor.forward])
        T_room_local = np.eye(4)
        T_room_local[:3, :3] = rotation
        level = points @ rotation[[0, 2]].T
        T_room_local[[0, 2], 3] = -_middle(level, viewpoints @ rotation[[0, 2]].T)
        T_room_local[1, 3] = -floor.height
        return T_room_local + 0.0  # no negative zeros


def _middle(level: NDArray[np.float64], sensors: NDArray[np.float64]) -> NDArray[np.float64]:
    """The point (2,) of the plan to stand at."""
    if len(level) == 0:
        return np.zeros(2)
    low, high = np.quantile(level, [0.02, 0.98], axis=0)
    if float((high - low).max()) <= _ROOM_SIZE:
        middle: NDArray[np.float64] = (low + high) / 2
        return middle
    sensor = np.median(sensors, axis=0) if len(sensors) else np.zeros(2)
    inside = bool((sensor >= low).all() and (sensor <= high).all())
    return sensor if inside else np.median(level, axis=0)
