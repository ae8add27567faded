"""The points of one sensor in a stored frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import DepthCamera
from pointbrush.sequences.depth.lattice import Lattice
from pointbrush.sequences.storage.sensors import StoredSensor
from pointbrush.values.kinds import SensorType


@dataclass(frozen=True, slots=True, eq=False)
class StoredPart:
    """One sensor in a frame.

    ``sensor``          its number in the recording's list, which ``StoredFrame.sensor`` has.
    ``T_frame_sensor``  (4, 4) corrected mount: its coordinates to local metres; the identity where
                        the recording has one sensor.
    ``viewpoint``       (3,) its position, local metres; None if that of one sensor is unknown.
    ``timestamp``       seconds, or None.
    ``lattice``         the pixels that its points lie on here, in its coordinates, or None.
    ``camera``          intrinsics of the depth image that ``StoredFrame.pixel`` counts in, or None.
    """

    sensor: int
    name: str
    type: SensorType
    T_frame_sensor: NDArray[np.float64]
    viewpoint: NDArray[np.float64] | None
    timestamp: float | None
    lattice: Lattice | None
    camera: DepthCamera | None

    @classmethod
    def alone(
        cls,
        viewpoint: NDArray[np.float64] | None,
        timestamp: float | None,
        lattice: Lattice | None,
        camera: DepthCamera | None,
    ) -> StoredPart:
        """Return the part of a recording of one sensor."""
        kind: SensorType = "unknown" if lattice is None else "depth"
        return cls(0, "", kind, np.eye(4), viewpoint, timestamp, lattice, camera)

    @classmethod
    def of(
        cls,
        number: int,
        stored: StoredSensor,
        frame: int,
        shift: NDArray[np.float64],
        *,
        on_lattice: bool,
        camera: dict[str, Any] | None,
    ) -> StoredPart:
        """Return the part of one of several sensors in a frame."""
        T_local_sensor = stored.mount(frame).copy()
        T_local_sensor[:3, 3] -= shift
        return cls(
            number,
            stored.name,
            stored.type,
            T_local_sensor,
            T_local_sensor[:3, 3],
            stored.times[frame],
            stored.lattice if on_lattice else None,
            None if camera is None else DepthCamera(**camera),
        )
