"""Kind of the sensor behind a frame, which the object tool and the tracker tell alike."""

from __future__ import annotations

from typing import Literal, get_args

SensorKind = Literal["camera", "lidar", "room"]
"""One view of a depth camera; one turn of a spinning lidar; a scan joined from many views."""

SENSOR_KINDS: tuple[SensorKind, ...] = get_args(SensorKind)
