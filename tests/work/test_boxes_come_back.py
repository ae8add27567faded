"""Whole boxes go out of a recording in every format, and come into another one as boxes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import pytest

from pointbrush.formats import EXPORTS
from pointbrush.formats.boxes.writing import ATTRIBUTES, HEADING, OBJECTS
from pointbrush.frame import PointFrame
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.geometry.quaternions import quaternion_of, rotation_of
from pointbrush.labels import Label
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.waiting import PATIENCE

CAR, WALKER = 3, 5
CENTRES = {CAR: np.array([12.0, -3.0, 0.8]), WALKER: np.array([5.0, 4.0, 0.9])}
SIZES = {CAR: np.array([4.4, 1.9, 1.6]), WALKER: np.array([0.6, 0.7, 1.8])}
TOLD = {"occluded": 1.0}


def centre(label: int, frame: int) -> np.ndarray:
    return np.asarray(CENTRES[label] + [0.5 * frame, 0, 0])


def turn(yaw: float) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def points(frame: int) -> np.ndarray:
    rng = np.random.default_rng(frame)
    inside = rng.uniform(-0.5, 0.5, (40, 3)) * SIZES[CAR] @ turn(0.4).T + centre(CAR, frame)
    ground = np.c_[rng.uniform(-20, 20, (60, 2)), np.full(60, -0.5)]
    return np.concatenate([inside, ground]).astype(np.float32)


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workspace]:
    place = tmp_path_factory.mktemp("boxes")
    for name in ("drive", "again"):
        import_frames(
            (PointFrame(points(k), timestamp=1533151603.5 + k / 10) for k in range(3)),
            place / "sequences" / name,
            RecordingInfo(name, name, 10.0),
        )
    opened = Workspace(Settings(workspace=place))
    labels = [
        Label(CAR, "van 1", "vehicle", "#ff8800"), Label(WALKER, "ann", "pedestrian", "#00ffaa"),
    ]  # fmt: skip
    opened.labels.apply(
        "drive",
        edit_id=str(uuid4()),
        author="ann",
        kind="label",
        writes=lambda _: (labels, ()),
        summary="",
        boxes=[
            OrientedBox(
                0,
                label,
                SIZES[label],
                {
                    frame: BoxPose(centre(label, frame), quaternion_of(turn(0.4)), attributes=TOLD)
                    for frame in range(3)
                },
                heading_known=label == CAR,
            )
            for label in (CAR, WALKER)
        ],
    )
    yield opened
    opened.close()


def bring(workspace: Workspace, place: Path, **options: Any) -> dict[str, Any]:
    job = workspace.imports.begin_labels("again", place, "bob", **options)
    done = workspace.runner.wait(job.id, PATIENCE)
    assert done.state == "done", done.error
    return dict(done.result or {})


WHOLE = [name for name, made in EXPORTS.items() if made.whole_boxes]


@pytest.mark.parametrize("kind", WHOLE)
def test_whole_boxes_come_into_a_copy(workspace: Workspace, tmp_path: Path, kind: str) -> None:
    workspace.export("drive", kind, tmp_path / "out")
    result = bring(workspace, tmp_path / "out")
    palette = {label.id: label for label in workspace.labels.palette("again")}
    boxes = workspace.labels.boxes.listing("again").boxes
    told = EXPORTS[kind].cannot_hold
    alone = OBJECTS in told
    assert len(boxes) == result["boxes"] == (6 if alone else 2)
    assert result["box_poses"] == 6
    assert result["labelled"] == 3 * 40  # the points of the car are labelled too
    for box in boxes:
        label = palette[box.label]
        mine = CAR if label.category == "vehicle" else WALKER
        assert label.category == ("vehicle" if mine == CAR else "pedestrian")
        assert np.allclose(box.size, SIZES[mine], atol=1e-3)
        assert box.provenance == "imported"
        assert box.heading_known == (mine == CAR or HEADING in told)
        if not alone:
            assert (label.name, sorted(box.poses)) == (("van 1", "ann")[mine == WALKER], [0, 1, 2])
        for frame, pose in box.poses.items():
            assert np.allclose(pose.centre, centre(mine, frame), atol=1e-3)
            assert np.allclose(rotation_of(pose.quaternion), turn(0.4), atol=1e-4)
            if ATTRIBUTES not in told:
                assert {**box.attributes, **pose.attributes} == TOLD
    workspace.labels.undo("again", "bob")
    assert workspace.labels.boxes.listing("again").boxes == ()
    assert workspace.labels.palette("again") == []


@pytest.mark.parametrize("kind", ["sustechpoints", "kitti-tracking", "argoverse2"])
def test_boxes_that_are_there_are_not_doubled(
    workspace: Workspace, tmp_path: Path, kind: str
) -> None:
    workspace.export("drive", kind, tmp_path / "some", frames="0:2")
    workspace.export("drive", kind, tmp_path / "all")
    assert bring(workspace, tmp_path / "some")["box_poses"] == 4
    for poses, known in ((2, 4), (0, 6)):
        trial = bring(workspace, tmp_path / "all", dry_run=True)
        assert (trial["box_poses"], trial["box_poses_known"]) == (poses, known)
        result = bring(workspace, tmp_path / "all")
        assert (result["box_poses"], result["box_poses_known"]) == (poses, known)
        boxes = workspace.labels.boxes.listing("again").boxes
        assert sum(len(box.poses) for box in boxes) == 6
    # A box that has moved is another one.
    box = boxes[0]
    workspace.labels.boxes.change("again", "bob", box.id, {"size": [9.0, 9.0, 9.0]})
    assert bring(workspace, tmp_path / "all")["box_poses"] == len(box.poses)
    while workspace.labels.stacks("again", "bob")[0]:
        workspace.labels.undo("again", "bob")
    assert workspace.labels.boxes.listing("again").boxes == ()


def test_boxes_are_kept_alone_or_become_points(workspace: Workspace, tmp_path: Path) -> None:
    workspace.export("drive", "sustechpoints", tmp_path / "out")
    trial = bring(workspace, tmp_path / "out", boxes="keep", dry_run=True)
    assert (trial["boxes"], trial["labelled"], trial["edit"]) == (2, 0, None)
    assert bring(workspace, tmp_path / "out", boxes="keep")["labelled"] == 0
    assert len(workspace.labels.boxes.listing("again").boxes) == 2
    workspace.labels.undo("again", "bob")
    assert bring(workspace, tmp_path / "out", boxes="points")["boxes"] == 0
    assert workspace.labels.boxes.listing("again").boxes == ()
    workspace.labels.undo("again", "bob")
