"""Messages with a frame of two depth cameras and a lidar, which the page's tests decode too.

``python -m tests.streaming.test_golden_sensors`` writes them anew after a deliberate change.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import msgpack
import numpy as np

from pointbrush.frame import FramePart, PointFrame, Sensor, join_sensors
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence, update_manifest
from pointbrush.streaming.encoding import encode_depth
from pointbrush.streaming.requests import sensor_info
from tests.sequences.test_depth_golden import LATTICE, small_frame, without_picture

GOLDEN = Path(__file__).parents[1] / "golden" / "sensors"
SENSORS = (Sensor("front", "depth"), Sensor("side", "depth"), Sensor("top", "spinning"))
TURNED = np.array([[0.6, 0, 0.8, -1.5], [0, 1, 0, 0.25], [-0.8, 0, 0.6, 2], [0, 0, 0, 1]])
RAISED = np.array([[0, -1, 0, 0.5], [1, 0, 0, 0], [0, 0, 1, 1.75], [0, 0, 0, 1.0]])
CORRECTION = np.array([[0.8, -0.6, 0, 0.03125], [0.6, 0.8, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
EVERY = 11
"""One point of so many is described."""


def rig() -> PointFrame:
    """A ball before a wall from two sides, and a spiral; in numbers that no platform rounds."""
    number = np.arange(400)
    spiral = np.stack([number % 20 - 10, number // 20 - 10, number % 7], axis=1) / 8
    lidar = PointFrame(
        spiral.astype(np.float32), np.stack([number % 256, number // 2, 0 * number], 1).astype("u1")
    )
    mounts = (np.eye(4), TURNED, RAISED)
    parts = [FramePart(sensor, mount) for sensor, mount in enumerate(mounts)]
    return join_sensors(SENSORS, list(zip(parts, (camera(1), camera(7), lidar), strict=True)))


def camera(step: int) -> PointFrame:
    """The golden depth image with its camera at the origin."""
    frame = small_frame(step)
    return PointFrame((frame.xyz - np.array(LATTICE.eye)).astype(np.float32), frame.rgb)


def content(folder: Path) -> tuple[list[bytes], dict[str, Any]]:
    """Return the first message and the rest of the frame, and its points as the server has them."""
    import_frames([rig()], folder, RecordingInfo("s", "A rig", 10.0))
    update_manifest(folder, corrections=[np.eye(4), CORRECTION, np.eye(4)])
    recording = open_sequence(folder)
    frame, manifest = recording[0], recording.manifest
    cut, end = 4, len(frame.chunks)
    messages = [
        b"".join(map(bytes, encode_depth("s", frame, *run, final=run[1] == end)))
        for run in ((0, cut), (cut, end))
    ]
    lo, hi = manifest.bounds
    return messages, {
        "sensors": [sensor_info(each, manifest).model_dump() for each in manifest.sensors],
        "lo": lo,
        "hi": hi,
        "position_error": manifest.position_error,
        "every": EVERY,
        "xyz_base64": base64.b64encode(frame.xyz[::EVERY].astype("<f4").tobytes()).decode(),
        "sensor": frame.sensor[::EVERY].tolist(),
    }


def chunks_of(message: bytes) -> list[tuple[Any, ...]]:
    """Return what a message tells of each chunk, bands without the pictures of a JPEG library."""
    read = msgpack.unpackb(message)
    found = []
    for chunk in read["chunks"]:
        data = read["data"][chunk["offset"] : chunk["offset"] + chunk["nbytes"]]
        facts = (chunk["index"], chunk["level"], chunk["first"], chunk["count"], chunk["sensor"])
        found.append((*facts, data if "origin" in chunk else without_picture(data)))
    return found


def test_golden_sensors_are_what_we_send(tmp_path: Path) -> None:
    messages, description = content(tmp_path / "s")
    kept = [GOLDEN.with_name(f"sensors_{i}.bin").read_bytes() for i in range(len(messages))]
    assert list(map(chunks_of, messages)) == list(map(chunks_of, kept))
    described = json.loads(GOLDEN.with_suffix(".json").read_text())
    assert description["sensor"] == described["sensor"]
    ours, theirs = (
        np.frombuffer(base64.b64decode(each["xyz_base64"]), "<f4")
        for each in (description, described)
    )
    np.testing.assert_allclose(ours, theirs, atol=1e-6)


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as made:
        data, text = content(Path(made) / "s")
    for number, message in enumerate(data):
        GOLDEN.with_name(f"sensors_{number}.bin").write_bytes(message)
    GOLDEN.with_suffix(".json").write_text(json.dumps(text) + "\n")
