"""Average precision, precision and recall of boxes, of cases that are counted by hand."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pointbrush.frame import PointFrame
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.serving import with_labels

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
CAR = np.array([4.0, 2.0, 1.5])


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    for name in ("truth", "found"):
        import_frames(
            (PointFrame(np.eye(3, dtype=np.float32)) for _ in range(2)),
            tmp_path / "sequences" / name,
            RecordingInfo(name, name, 10.0),
        )
    opened = Workspace(with_labels(Settings(workspace=tmp_path)))
    yield opened
    opened.close()


def draw(workspace: Workspace, recording: str, *places: tuple[float, float]) -> None:
    """Add a car for each place ahead, and the confidence of its box, in both frames."""
    for number, (ahead, confidence) in enumerate(places, start=1):
        label = workspace.labels.create_label(
            recording, "ann", name=f"car {number}", category="car"
        )
        pose = BoxPose(np.array([ahead, 0.0, 0.0]), LEVEL, confidence=confidence)
        box = OrientedBox(0, label.id, CAR, {0: pose, 1: pose})
        workspace.labels.boxes.add(recording, "ann", box)


def test_boxes_are_scored_by_their_confidence(workspace: Workspace) -> None:
    draw(workspace, "truth", (0.0, 1.0), (20.0, 1.0))
    # One is half a metre off, IoU 7 / 9; one is nowhere, and surer than the third, which is right.
    draw(workspace, "found", (0.5, 0.9), (60.0, 0.8), (20.0, 0.7))
    (car,) = workspace.reviewing.box_agreement("truth", "found").classes
    assert (car.name, car.first, car.second) == ("car", 4, 6)
    assert car.mean_iou == pytest.approx((7 / 9 + 1) / 2)
    for score in car.scores:
        assert score.recall == 1
        assert score.precision == pytest.approx(2 / 3)
        assert score.ap == pytest.approx((1 + 2 / 3) / 2)
    one = workspace.reviewing.box_agreement("truth", "found", "0").classes[0]
    assert (one.first, one.second) == (2, 3)


def test_boxes_too_far_off_are_missed_at_the_greater_overlap(workspace: Workspace) -> None:
    draw(workspace, "truth", (0.0, 1.0))
    draw(workspace, "found", (1.0, 1.0))  # IoU 3 / 5
    (car,) = workspace.reviewing.box_agreement("truth", "found").classes
    assert [(score.iou, score.ap, score.recall) for score in car.scores] == [
        (0.5, 1, 1),
        (0.7, 0, 0),
    ]
    assert workspace.reviewing.box_agreement("found", "found", "1").classes[0].scores[1].ap == 1
