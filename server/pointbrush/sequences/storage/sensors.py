"""The sensors of a recording as its manifest has them, and their mounts with corrections."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.geometry.mounts import rigid_mount
from pointbrush.sequences.depth.lattice import Lattice, lattice_of
from pointbrush.values.kinds import SensorType

Matrix = list[float]
"""Row-major 4x4."""
IDENTITY: Matrix = np.eye(4).ravel().tolist()


@dataclass(frozen=True, slots=True)
class StoredSensor:
    """One of several sensors of a recording.

    ``lattice``     pixels that its points lie on, in its coordinates, or None.
    ``mounts``      ``T_frame_sensor``, row-major 4x4: one for all frames, or one a frame.
    ``times``       seconds per frame, or None; ``points`` per frame.
    ``lo``, ``hi``  bounds over all frames, in its coordinates.
    ``correction``  row-major 4x4: a point of the sensor is at ``mount @ correction`` times its
                    coordinates in the frame.
    ``previous``    correction before the last change, or None; all other fields never change.
    """

    name: str
    type: SensorType
    lattice: Lattice | None
    mounts: list[Matrix]
    times: list[float | None]
    points: list[int]
    lo: list[float]
    hi: list[float]
    correction: Matrix
    previous: Matrix | None = None

    def imported_mount(self, frame: int) -> NDArray[np.float64]:
        """Return ``T_frame_sensor`` (4, 4) of a frame as it was imported."""
        return np.array(self.mounts[frame if len(self.mounts) > 1 else 0]).reshape(4, 4)

    def mount(self, frame: int) -> NDArray[np.float64]:
        """Return ``T_frame_sensor`` (4, 4) of a frame with the correction."""
        if not self.corrected:
            return self.imported_mount(frame)
        mount: NDArray[np.float64] = self.imported_mount(frame) @ np.reshape(
            self.correction, (4, 4)
        )
        return mount

    @property
    def corrected(self) -> bool:
        """Return whether there is a correction."""
        return self.correction != IDENTITY

    def greatest_shift(self) -> NDArray[np.float64]:
        """Return the greatest shift (3,) of a point by the correction along each axis, metres."""
        corners = np.array(
            [[*corner, 1.0] for corner in product(*zip(self.lo, self.hi, strict=True))]
        )
        change = np.reshape(self.correction, (4, 4)) - np.eye(4)
        shifts = np.reshape(self.mounts, (-1, 4, 4)) @ (change @ corners.T)
        greatest: NDArray[np.float64] = np.abs(shifts[:, :3]).max(axis=(0, 2))
        return greatest


def sensor_of(content: dict[str, Any]) -> StoredSensor:
    """Return a sensor of its JSON."""
    return StoredSensor(**content | {"lattice": lattice_of(content["lattice"])})


def require_rigid(name: str, matrix: Any) -> Matrix:
    """Return a row-major 4x4 of a rigid transform; raises BadInputError for another matrix."""
    return [float(value) for value in rigid_mount(name, matrix).ravel()]
