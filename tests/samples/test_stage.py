"""The stage: cameras around the jugglers, whose points meet by the true mounts."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from pointbrush.errors import BadInputError
from pointbrush.samples.generating import small_camera
from pointbrush.samples.geometry import inverse
from pointbrush.samples.sensor import KINECT
from pointbrush.samples.stage import Stage, StageOptions
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence

SMALL = small_camera(KINECT, 3)


def test_points_of_all_cameras_meet_by_the_true_mounts() -> None:
    stage = Stage(3, 2, StageOptions(), camera=SMALL)
    frame, truth = stage.frame(1), stage.truth[1]
    T_room_frame = stage.views[0].scene.camera_pose
    for camera in range(3):
        mine = frame.sensor == camera
        np.testing.assert_array_equal(frame.sensor_xyz[mine], stage.views[camera].frame(1).xyz)
        room = frame.xyz[mine] @ T_room_frame[:3, :3].T + T_room_frame[:3, 3]
        floor = room[(np.abs(room[:, 1]) < 0.1) & (truth[mine] == 0)]
        assert len(floor) > 1000
        assert abs(np.median(floor[:, 1])) < 0.02  # the rug is 12 mm thick
        for label, poses in stage.poses.items():
            pin = frame.xyz[mine & (truth == label)] - poses[1][:3, 3]
            assert np.linalg.norm(pin, axis=1).max(initial=0) < 0.35
    people = [label.id for label in stage.labels if label.category == "person"]
    assert all(
        (frame.sensor[truth == person] == k).sum() > 300 for k in range(3) for person in people
    )


def test_given_mounts_are_wrong_by_the_given_errors_but_for_the_first() -> None:
    stage = Stage(3, 1, StageOptions(cameras=2, error_metres=0.02, error_degrees=2.0), camera=SMALL)
    np.testing.assert_array_equal(stage.mounts[0], np.eye(4))
    error = inverse(stage.true_mounts[1]) @ stage.mounts[1]
    angle = np.degrees(np.arccos((np.trace(error[:3, :3]) - 1) / 2))
    np.testing.assert_allclose([np.linalg.norm(error[:3, 3]), angle], [0.02, 2.0], rtol=1e-6)
    np.testing.assert_array_equal(stage.frame(0).parts[1].T_frame_sensor, stage.mounts[1])
    with pytest.raises(BadInputError, match="cameras: expected 2 or 3, got 1"):
        Stage(3, 1, StageOptions(cameras=1))


def test_depths_have_the_noise_of_a_kinect() -> None:
    """Its standard deviation is about 1.5 - 0.5 z + 0.3 z² mm at z metres (Fankhauser et al.)."""
    measured, exact = (
        Stage(3, 1, StageOptions(), noise=noise).views[1].frame(0) for noise in (1.0, 0.0)
    )
    _, one, other = np.intersect1d(measured.pixel, exact.pixel, return_indices=True)
    z = exact.xyz[other, 2]
    error = 1000 * np.abs(measured.xyz[one, 2] - z)
    for near in (2, 3, 4, 5):
        inside = (z >= near) & (z < near + 1)
        middle = near + 0.5
        sigma = 1.4826 * np.median(error[inside])
        assert 0.7 < sigma / (1.5 - 0.5 * middle + 0.3 * middle**2) < 1.5


def test_each_camera_is_sent_as_a_depth_image(tmp_path: Path) -> None:
    stage = Stage(3, 1, StageOptions())
    import_frames(stage.frames, tmp_path / "s", RecordingInfo("s", "Stage", stage.fps))
    stored = open_sequence(tmp_path / "s")[0]
    assert stored.sensor_xyz().tobytes() == stage.frame(0).sensor_xyz.tobytes()
    ends = [stored.depth_start(chunk) for chunk in range(len(stored.chunks) + 1)]
    for part in stored.parts:
        mine = stored.chunk_table["sensor"] == part.sensor
        assert part.camera is not None
        assert asdict(part.camera) == asdict(KINECT)
        assert np.diff(ends)[mine].sum() <= stored.chunk_table["count"][mine].sum()
