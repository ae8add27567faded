"""Frames of several sensors: stored bit for bit, placed by mounts that can be corrected."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pointbrush.frame import FramePart, PointFrame, Sensor, join_sensors
from pointbrush.samples.geometry import axis_angle, rigid, vec
from pointbrush.sequences import RecordingInfo, StoredFrame, import_frames, open_sequence, verify

SENSORS = (Sensor("left", "spinning"), Sensor("right", "radar"), Sensor("rear"))


def mount(seed: int) -> np.ndarray[Any, Any]:
    rng = np.random.default_rng([seed, 5])
    return rigid(axis_angle(vec(*rng.normal(size=3)), rng.uniform(0, 3)), rng.uniform(-4, 4, 3))


def cloud(count: int, seed: int, dtype: type = np.float32, **more: Any) -> PointFrame:
    rng = np.random.default_rng(seed)
    xyz = rng.normal(0, 3, (count, 3)).astype(dtype)
    return PointFrame(xyz, rgb=rng.integers(0, 255, (count, 3), np.uint8), **more)


def frame_of(counts: dict[int, int], seed: int, dtype: type = np.float32) -> PointFrame:
    given = [
        (FramePart(sensor, mount(sensor), 0.1 * sensor), cloud(count, seed + sensor, dtype))
        for sensor, count in counts.items()
    ]
    return join_sensors(SENSORS, given, timestamp=float(seed))


def put(frames: list[PointFrame], target: Path) -> list[StoredFrame]:
    import_frames(frames, target, RecordingInfo("s", "A rig", 10.0))
    assert verify(target) == []
    return list(open_sequence(target))


@settings(max_examples=15)
@given(
    counts=st.lists(
        st.dictionaries(st.integers(0, 2), st.integers(0, 9000), min_size=1), min_size=1, max_size=3
    ),
    far=st.booleans(),
    seed=st.integers(0, 99),
)
def test_frames_come_back_bit_for_bit_per_sensor(
    tmp_path_factory: pytest.TempPathFactory, counts: list[dict[int, int]], far: bool, seed: int
) -> None:
    frames = [
        frame_of(dict(sorted(each.items())), seed + k, np.float64 if far else np.float32)
        for k, each in enumerate(counts)
    ]
    for frame, stored in zip(frames, put(frames, tmp_path_factory.mktemp("s") / "s"), strict=True):
        assert stored.sensors == SENSORS
        assert stored.sensor is not None
        np.testing.assert_array_equal(stored.to_source(stored.sensor), frame.sensor)
        assert stored.sensor_xyz().tobytes() == frame.sensor_xyz.tobytes()
        assert stored.sensor_xyz().dtype == frame.sensor_xyz.dtype
        assert stored.source_xyz().tobytes() == frame.xyz.tobytes()
        np.testing.assert_array_equal(stored.to_source(stored.rgb), frame.rgb)
        for part in stored.parts:
            mine = stored.sensor == part.sensor
            np.testing.assert_array_equal(part.T_frame_sensor, mount(part.sensor))
            assert part.timestamp == 0.1 * part.sensor
            assert mine.any()
        # Every chunk holds points of one sensor, and levels follow one another.
        sensors, levels = stored.chunk_table["sensor"], stored.chunk_table["level"].tolist()
        assert levels == sorted(levels)
        for chunk, sensor in zip(stored.chunks, sensors.tolist(), strict=True):
            assert chunk.sensor == sensor
            assert (stored.sensor[chunk.first : chunk.first + chunk.count] == sensor).all()
            own = stored.xyz[chunk.first : chunk.first + chunk.count]
            np.testing.assert_array_equal(own.min(axis=0), np.float32(chunk.lo))
            np.testing.assert_array_equal(own.max(axis=0), np.float32(chunk.hi))
