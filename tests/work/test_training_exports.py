"""Exports for training whose points were moved and turned: their boxes come back."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from pointbrush.frame import PointFrame
from pointbrush.sequences import import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace

UTM = np.array([388_096.0, 5_948_996.0, 40.0])
CAR = 200


@pytest.mark.parametrize("offset", [UTM, np.zeros(3)], ids=["map", "near"])
@pytest.mark.parametrize("up", ["z", "-y"], ids=["lidar", "camera"])
def test_boxes_of_openpcdet_come_back_to_the_source(
    tmp_path: Path, offset: np.ndarray, up: str
) -> None:
    rng = np.random.default_rng(0)
    car = rng.uniform([3, -1, 5], [7, 0.5, 7], (CAR, 3))
    far = rng.uniform([-20, -20, 20], [20, 20, 30], (200, 3))
    frame = PointFrame(xyz=np.concatenate([car, far]) + offset)
    settings = Settings(workspace=tmp_path / "workspace")
    place = settings.workspace / "sequences" / "scan"
    import_frames([frame], place, sequence_id="scan", name="scan", fps=1.0, up=up)
    with closing(Workspace(settings)) as workspace:
        made = workspace.create_label("scan", "ann", name="car", category="car")
        label = np.where(np.arange(400) < CAR, made.id, 0).astype(np.uint16)
        workspace.put_annotation("scan", 0, label, author="ann")
        workspace.export("scan", "openpcdet", tmp_path / "out")
        workspace.put_annotation("scan", 0, np.zeros(400, np.uint16), author="ann")
        job = workspace.import_labels("scan", tmp_path / "out", "bob")
        done = workspace.runner.wait(job.id, 120)
        assert done.state == "done", done.error
        back = workspace.annotation("scan", 0)[0]
    assert np.count_nonzero(back[:CAR]) >= 0.97 * CAR  # those on the box's faces may be outside
    assert not back[CAR:].any()
