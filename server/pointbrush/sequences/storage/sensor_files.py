"""The files of a frame of several sensors: its points are stored in their sensors' coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.columns import from_local, to_local
from pointbrush.sequences.octree.arrays import Arrays
from pointbrush.sequences.sensor_chunks import place_chunks, sensors_of_chunks
from pointbrush.sequences.storage.frame_files import CopiedFiles
from pointbrush.sequences.storage.manifest import Manifest

_PLACED_BYTES = 25
"""Bytes that a placed point takes beside the stored arrays: positions, and its sensor."""
_ROUNDING = 2.0**-22
"""Share of a coordinate by which single precision rounds it, and a moved box is widened."""


class SensorFiles(CopiedFiles):
    """Arrays as of one sensor, with ``xyz`` placed by the corrected mounts.

    Further arrays: ``sensor`` (N,) uint8, and ``sensor_xyz`` (N, 3) as imported.
    """

    def __init__(
        self,
        folder: Path,
        index: int,
        manifest: Manifest,
        checksums: Mapping[str, str],
        held: object = None,
    ) -> None:
        sensors = manifest.sensors
        self._mounts = np.array([sensor.mount(index) for sensor in sensors])
        """``T_frame_sensor`` (S, 4, 4), corrected."""
        moves = [
            sensor.mount(index) @ np.linalg.inv(sensor.imported_mount(index))
            if sensor.corrected
            else np.eye(4)
            for sensor in sensors
        ]
        self._moves = np.array(moves)
        """Transforms (S, 4, 4) by the corrections, in the frame's coordinates."""
        self._moved = any(sensor.corrected for sensor in sensors)
        super().__init__(folder, index, manifest, checksums, held)

    def _open(self) -> None:
        super()._open()
        self.names |= {"sensor", "sensor_xyz"}
        if self._moved:
            self.chunks = self.chunks.copy()
            lo, hi = self._moved_boxes(self.chunks["lo"], self.chunks["hi"], self.chunks["sensor"])
            self.chunks["lo"], self.chunks["hi"] = lo, hi

    @property
    def _copied_bytes(self) -> int:
        return super()._copied_bytes + _PLACED_BYTES * self.count

    def _copy(self) -> Arrays:
        arrays = dict(super()._copy())
        own, chunks = arrays["xyz"], self.chunks
        dtype = np.dtype(self.meta["sensor_dtype"])
        sensor_xyz = from_local(own, arrays.get("residual"), np.zeros(3), dtype)
        placed = place_chunks(sensor_xyz, chunks, self._mounts, self.dtype)
        made: Arrays = {
            "xyz": to_local(placed, self._shift),
            "sensor": sensors_of_chunks(chunks),
            "sensor_xyz": sensor_xyz,
        }
        if self._moved:
            sensor = np.repeat(chunks["sensor"], np.diff(arrays["block_of_chunk"]))
            boxes = self._moved_boxes(arrays["block_lo"], arrays["block_hi"], sensor)
            made["block_lo"], made["block_hi"] = boxes
        for array in made.values():
            array.flags.writeable = False
        return arrays | made

    def source(self, first: int, stop: int) -> NDArray[Any]:
        """Coordinates of points ``first`` to before ``stop`` by the corrected mounts."""
        if self.dtype == np.float32 and not self._shift.any():
            return self.rows("xyz", first, stop)
        arrays = self.arrays()
        return place_chunks(arrays["sensor_xyz"], self.chunks, self._mounts, self.dtype)[first:stop]

    def _moved_boxes(
        self, lo: NDArray[np.float32], hi: NDArray[np.float32], sensor: NDArray[np.uint8]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return boxes (B, 3), local, around boxes of sensors (B,) that their corrections move."""
        moves = self._moves[sensor]
        middle = (lo.astype(np.float64) + hi) / 2 + self._shift
        half = (hi.astype(np.float64) - lo) / 2
        middle = np.einsum("bij,bj->bi", moves[:, :3, :3], middle) + moves[:, :3, 3] - self._shift
        half = np.einsum("bij,bj->bi", np.abs(moves[:, :3, :3]), half)
        half += _ROUNDING * (np.abs(middle) + half)
        return (middle - half).astype(np.float32), (middle + half).astype(np.float32)
