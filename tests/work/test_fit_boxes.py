"""Boxes fitted to the labels of a recording, by the command and as a job."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pointbrush.cli import main
from pointbrush.commands.following import follow
from pointbrush.database.job import Job
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.settings import Settings
from pointbrush.values.boxes import BoxFit
from pointbrush.workspace import Workspace
from tests.fitting.cars import SIZE, seen

CAR = 7


@pytest.fixture(scope="module")
def street(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with a drive past a parked car, labelled in three frames of four."""
    return drive(tmp_path_factory.mktemp("street"), [0, 0.1, 0.2, 0.3])


def drive(folder: Path, times: Sequence[float]) -> Path:
    """A workspace with a drive past a parked car at ``times``, labelled in three frames of four."""
    files = folder / "files"
    files.mkdir()
    for frame, time in enumerate(times):
        car = seen("rtb", 0.0, (9.0 - frame, 4.0), frame)
        xyz = np.concatenate([car.xyz, car.others])
        label = np.where(np.arange(len(xyz)) < len(car.xyz), CAR * (frame < 3), 0)
        pose = np.eye(4)
        pose[0, 3] = frame
        np.savez(
            files / f"{frame:04}.npz", xyz=xyz.astype(np.float32), pose=pose,
            viewpoint=car.sensor, label=label.astype(np.uint16), timestamp=time,
        )  # fmt: skip
    command = ["import", str(files), "--name", "street", "--workspace", str(folder / "workspace")]
    assert main([*command, "--up", "z"]) == 0
    return folder / "workspace"


def ended(workspace: Workspace, **chosen: object) -> Job:
    """The job of a fit when it has ended."""
    job = workspace.fitting.fit("street", BoxFit(**chosen), "me")  # type: ignore[arg-type]
    follow(workspace.jobs.get, job)
    return workspace.jobs.get(job.id)


def test_a_fit_is_one_edit_and_leaves_what_somebody_drew(street: Path) -> None:
    assert main(["fit-boxes", "street", "--labels", str(CAR), "--workspace", str(street)]) == 0
    with closing(Workspace(Settings(workspace=street))) as workspace:
        boxes = workspace.labels.boxes
        (box,) = boxes.listing("street").boxes
        assert (box.label, box.provenance, sorted(box.poses)) == (CAR, "fitted", [0, 1, 2])
        assert box.size[:2] == pytest.approx(SIZE[:2], abs=0.3)
        places = [box.poses[frame].centre + [frame, 0, 0] for frame in box.poses]
        assert np.ptp(places, axis=0).max() < 0.02
        drawn = BoxPose(np.array([5.0, 4, 1]), np.array([0.0, 0, 0, 1]))
        boxes.apply(
            "street", "me",
            lambda now: _edit(replace(now[box.id], poses={**now[box.id].poses, 1: drawn})),
            summary="draw",
        )  # fmt: skip
        job = ended(workspace, labels=(CAR,))
        assert (job.result or {})["fitted"] == [box.id]
        again = boxes.get("street", box.id)
        assert again.poses[1].centre == pytest.approx(drawn.centre)
        assert again.poses[0].centre == pytest.approx(box.poses[0].centre, abs=0.01)
        workspace.labels.undo("street", "me")
        assert ended(workspace, redraw=True).state == "done"
        assert boxes.get("street", box.id).poses[1].provenance == "fitted"


def test_frames_of_equal_times_fit_the_same_box(tmp_path: Path) -> None:
    workspace = drive(tmp_path, [5.0, 5.0, 5.1, 5.1])
    assert main(["fit-boxes", "street", "--labels", str(CAR), "--workspace", str(workspace)]) == 0
    with closing(Workspace(Settings(workspace=workspace))) as opened:
        (box,) = opened.labels.boxes.listing("street").boxes
    assert box.size[:2] == pytest.approx(SIZE[:2], abs=0.3)
    assert [box.poses[frame].centre[0] + frame for frame in range(3)] == pytest.approx(
        [9.0] * 3, abs=0.2
    )


def _edit(box: OrientedBox):  # type: ignore[no-untyped-def]
    from pointbrush.labels.boxes.editing import BoxEdit

    return BoxEdit([box])
