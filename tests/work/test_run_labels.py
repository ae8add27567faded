"""A label that is deleted or locked while a run goes on costs that label, not the run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from pointbrush.database.job import Job
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.values.runs import TrackingRequest
from pointbrush.work.events import Event, Provisional
from pointbrush.workspace import Workspace
from tests.serving import settings_in
from tests.waiting import PATIENCE

SEQUENCE, FRAMES = "balls", 6
PLACES = {1: (-0.4, 0.0, 1.0), 2: (0.4, 0.0, 1.0)}


def frames() -> Iterator[PointFrame]:
    """Two balls, one of each label, that move 2 cm a frame before a wall."""
    rng = np.random.default_rng(0)
    wall = np.column_stack([rng.uniform(-1, 1, (1500, 2)), np.full(1500, 2.0)])
    way = rng.normal(size=(400, 3))
    ball = 0.1 * way / np.linalg.norm(way, axis=1, keepdims=True)
    for i in range(FRAMES):
        balls = [ball + np.add(place, [0, 0.02 * i, 0]) for place in PLACES.values()]
        yield PointFrame(np.concatenate([wall, *balls]).astype(np.float32))


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    settings = settings_in(tmp_path)
    folder = settings.workspace / "sequences" / SEQUENCE
    import_frames(frames(), folder, RecordingInfo(SEQUENCE, SEQUENCE, 30))
    with closing(Workspace(settings)) as opened:
        for number, place in PLACES.items():
            opened.labels.create_label(SEQUENCE, "ada", name=f"ball {number}")
            stroke = {"shape": "sphere", "radius": 0.15, "samples": [{"origin": list(place)}]}
            opened.strokes.apply(SEQUENCE, 0, {**stroke, "label": number}, "ada")
        yield opened


def track(workspace: Workspace, meanwhile: Callable[[], object]) -> Job:
    """A run of both labels; ``meanwhile`` is called when its second result has come."""

    def listen(event: Event) -> None:
        if isinstance(event, Provisional) and event.frame == 1:
            meanwhile()

    undo = workspace.subscribe(listen)
    started = workspace.tracking.start(
        SEQUENCE, TrackingRequest("icp", start=0, stop=FRAMES - 1), "ada"
    )
    job = workspace.runner.wait(started.id, PATIENCE)
    undo()
    assert job.state == "done", job.error
    return job


def points(workspace: Workspace, label: int) -> list[int]:
    return [
        int((workspace.annotations.read(SEQUENCE, i)[0] == label).sum()) for i in range(1, FRAMES)
    ]


def test_a_label_that_is_deleted_meanwhile(workspace: Workspace) -> None:
    job = track(workspace, lambda: workspace.labels.delete_label(SEQUENCE, "bob", 1))
    assert min(points(workspace, 2)) > 300
    assert points(workspace, 1) == [0] * (FRAMES - 1)
    assert job.message == "left out, changed during tracking: 'ball 1' was deleted"
    assert job.result is not None
    assert job.result["left_out"] == [{"label": 1, "name": "ball 1", "why": "deleted"}]
    assert {track["label"] for track in workspace.labels.tracks(SEQUENCE)} == {2}
    # Who brings the label back has it as it was, and the run beside it.
    workspace.labels.undo(SEQUENCE, "bob")
    assert (workspace.annotations.read(SEQUENCE, 0)[0] == 1).any()
    assert min(points(workspace, 2)) > 300
    assert workspace.listing.problems(SEQUENCE) == []


def test_a_label_that_is_locked_meanwhile(workspace: Workspace) -> None:
    job = track(workspace, lambda: workspace.labels.update_label(SEQUENCE, "bob", 2, locked=True))
    assert min(points(workspace, 1)) > 300
    assert points(workspace, 2) == [0] * (FRAMES - 1)
    assert "'ball 2' was locked" in job.message


def test_a_run_whose_only_labels_went_changes_nothing(workspace: Workspace) -> None:
    def remove() -> None:
        for number in PLACES:
            workspace.labels.delete_label(SEQUENCE, "bob", number)

    before = len(workspace.labels.edits(SEQUENCE))
    job = track(workspace, remove)
    assert job.result is not None
    assert (job.result["edit"], job.result["changed"]) == (None, 0)
    assert "'ball 1' was deleted, 'ball 2' was deleted" in job.message
    assert len(workspace.labels.edits(SEQUENCE)) == before + len(PLACES)


def test_a_run_that_nothing_disturbs_says_nothing_of_it(workspace: Workspace) -> None:
    job = track(workspace, lambda: None)
    assert job.result is not None
    assert job.result["left_out"] == []
    assert job.message == "ball 1: 5 frames; ball 2: 5 frames"
    assert min(points(workspace, 1) + points(workspace, 2)) > 300
