"""Exports for training: boxes of points that were moved and turned come back; splits."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pointbrush.errors import BadInputError
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.depth_camera import depth_camera

UTM = np.array([388_096.0, 5_948_996.0, 40.0])
CAR = 200
SPLITS = ("train", "val")


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
    import_frames([frame], place, RecordingInfo("scan", "scan", 1.0, up=up))
    with closing(Workspace(settings)) as workspace:
        made = workspace.labels.create_label("scan", "ann", name="car", category="car")
        label = np.where(np.arange(400) < CAR, made.id, 0).astype(np.uint16)
        workspace.annotations.put("scan", 0, label, author="ann")
        workspace.export("scan", "openpcdet", tmp_path / "out")
        workspace.annotations.put("scan", 0, np.zeros(400, np.uint16), author="ann")
        job = workspace.imports.begin_labels("scan", tmp_path / "out", "bob")
        done = workspace.runner.wait(job.id, 120)
        assert done.state == "done", done.error
        back = workspace.annotations.read("scan", 0)[0]
    assert np.count_nonzero(back[:CAR]) >= 0.97 * CAR  # those on the box's faces may be outside
    assert not back[CAR:].any()


@pytest.mark.parametrize("up", ["-y", None])
def test_points_of_a_depth_camera_have_x_ahead_and_z_up(tmp_path: Path, up: str | None) -> None:
    frame = depth_camera(0)
    settings = Settings(workspace=tmp_path / "workspace")
    place = settings.workspace / "sequences" / "room"
    import_frames([frame], place, RecordingInfo("room", "room", 1.0, up=up))
    with closing(Workspace(settings)) as workspace:
        workspace.export("room", "openpcdet", tmp_path / "out")
    got = np.load(tmp_path / "out" / "points" / "room_000000.npy")[:, :3]
    right, down, ahead = frame.xyz.T
    for axis, expected in zip(got.T, (ahead, -right, -down), strict=True):
        assert np.corrcoef(axis, expected)[0, 1] > 0.95


@pytest.fixture
def drives(tmp_path: Path) -> Iterator[Workspace]:
    """A workspace of 12 recordings of 4 frames, of which three are for validation by their ids."""
    settings = Settings(workspace=tmp_path / "workspace")
    frames = [PointFrame(xyz=np.zeros((1, 3)) + i) for i in range(4)]
    for name in (f"scan-{number}" for number in range(12)):
        place = settings.workspace / "sequences" / name
        import_frames(frames, place, RecordingInfo(name, name, 1.0))
    with closing(Workspace(settings)) as workspace:
        yield workspace


def told_split(workspace: Workspace, out: Path, drive: str, val: str | None) -> dict[str, Any]:
    workspace.export(drive, "openpcdet", out, val=val)
    told = json.loads((out / "export.json").read_text())["split"]
    lists = {name: (out / "ImageSets" / f"{name}.txt").read_text().split() for name in SPLITS}
    assert lists == {name: told[name] for name in SPLITS}
    return {"by": told["by"]} | {
        name: [int(scene.removeprefix(f"{drive}_")) for scene in told[name]] for name in SPLITS
    }


@pytest.mark.parametrize(
    ("val", "frames"),
    [
        ("1:3", [1, 2]),
        ("2:", [2, 3]),
        ("scan-3", [0, 1, 2, 3]),
        ("scan-3,scan-5", [0, 1, 2, 3]),
        ("scan-5", []),
        ("none", []),
    ],
)
def test_frames_for_validation_are_those_asked_for(
    drives: Workspace, tmp_path: Path, val: str, frames: list[int]
) -> None:
    told = told_split(drives, tmp_path / "out", "scan-3", val)
    assert told["val"] == frames
    assert told["train"] == [i for i in range(4) if i not in frames]
    assert val in told["by"]


def test_by_default_some_recordings_are_for_validation_whole(
    drives: Workspace, tmp_path: Path
) -> None:
    told = [told_split(drives, tmp_path / f"{i}", f"scan-{i}", None) for i in range(12)]
    assert {(len(each["train"]), len(each["val"])) for each in told} == {(4, 0), (0, 4)}
    chosen = next(i for i, each in enumerate(told) if each["val"])
    for number in set(range(12)) - {chosen}:
        drives.deletion.delete(f"scan-{number}")
    alone = told_split(drives, tmp_path / "alone", f"scan-{chosen}", None)
    assert (len(alone["train"]), alone["val"]) == (4, [])
    assert "default" in alone["by"]
    assert "never all" in alone["by"]


@pytest.mark.parametrize(
    ("format", "val", "message"),
    [
        (
            "openpcdet",
            "scan-77",
            "expected frames I:J, ids of recordings, or none, got 'scan-77'",
        ),
        ("openpcdet", "3:9", "expected a range within 0:4"),
        ("openpcdet", "", "expected frames I:J"),
        (
            "ply",
            "1:3",
            "expected one of the formats pointcept, openpcdet, openpcdet-boxes with it, got ply",
        ),
    ],
)
def test_validation_that_cannot_be_is_refused(
    drives: Workspace, tmp_path: Path, format: str, val: str, message: str
) -> None:
    with pytest.raises(BadInputError, match=message):
        drives.export("scan-3", format, tmp_path / "out", val=val)
    assert not (tmp_path / "out").exists()
