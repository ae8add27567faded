"""Traffic of the samples: its true boxes hold what the lidar sees, and move as their labels do."""

from __future__ import annotations

import numpy as np
import pytest

from pointbrush_samples.traffic import TrueTraffic, traffic


@pytest.fixture(scope="module")
def drive() -> TrueTraffic:
    return traffic(3, 2)


def test_the_points_of_a_label_are_in_its_box_but_for_noise(drive: TrueTraffic) -> None:
    for frame, made in enumerate(drive.frames):
        for label in np.unique(made.instance[made.instance > 0]).tolist():
            box = drive.boxes[label]
            T = box.poses[frame].transform
            local = (made.frame.xyz[made.instance == label] - T[:3, 3]) @ T[:3, :3]
            assert (np.abs(local) < box.size / 2 + 0.1).all()


def test_what_moves_goes_ahead_and_the_rest_stays(drive: TrueTraffic) -> None:
    for label, box in drive.boxes.items():
        first, last = (
            made.T_room_frame @ box.poses[frame].transform
            for frame, made in enumerate(drive.frames)
        )
        went = last[:3, 3] - first[:3, 3]
        if label in drive.moving:
            assert went @ first[:3, 0] > 0.9 * np.linalg.norm(went) > 0.05
        else:
            assert np.abs(went).max() < 1e-9
