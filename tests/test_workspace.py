"""The façade: what sequences, labels, tracking and jobs do together."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from serving import settings_in

from pointbrush.errors import (
    BadInputError,
    ConflictError,
    LockedLabelError,
    NotFoundError,
)
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.values.runs import TrackingRequest
from pointbrush.work.events import Event, Provisional, Retracted
from pointbrush.workspace import Workspace
from tests.waiting import PATIENCE

SEQUENCE = "ball"
FRAMES = 8
WALL = 3000
STEP = 0.03


def frames() -> Iterator[PointFrame]:
    """A ball of 600 points that moves 3 cm a frame before a wall."""
    rng = np.random.default_rng(0)
    wall = np.column_stack([rng.uniform(-1, 1, (WALL, 2)), np.full(WALL, 2.0)])
    ball = rng.normal(size=(600, 3))
    ball *= 0.1 / np.linalg.norm(ball, axis=1, keepdims=True)
    rgb = np.repeat(np.array([[90, 90, 90], [200, 40, 40]], np.uint8), [WALL, 600], axis=0)
    for i in range(FRAMES):
        yield PointFrame(np.concatenate([wall, ball + [STEP * i, 0, 1]]).astype(np.float32), rgb)


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    settings = settings_in(tmp_path)
    import_frames(
        frames(), settings.workspace / "sequences" / SEQUENCE, RecordingInfo(SEQUENCE, SEQUENCE, 30)
    )
    opened = Workspace(settings)
    opened.labels.create_label(SEQUENCE, "ada", name="ball")
    yield opened
    opened.close()


def paint(workspace: Workspace, frame: int, label: int = 1, **fields: object) -> int:
    stroke = {
        "label": label,
        "shape": "sphere",
        "radius": 0.15,
        "samples": [{"origin": [STEP * frame, 0, 1]}],
        **fields,
    }
    return workspace.strokes.apply(SEQUENCE, frame, stroke, "ada").changed


def track(workspace: Workspace, **options: object) -> dict[str, object]:
    request = TrackingRequest(**{"start": 0, "stop": FRAMES - 1, "method": "icp", **options})  # type: ignore[arg-type]
    job = workspace.runner.wait(workspace.tracking.start(SEQUENCE, request, "ada").id, PATIENCE)
    assert job.state == "done", job.error
    assert job.result is not None
    return job.result


def label(workspace: Workspace, frame: int) -> NDArray[np.uint16]:
    return workspace.annotations.read(SEQUENCE, frame)[0]


def provenance(workspace: Workspace, frame: int) -> NDArray[np.uint8]:
    return workspace.annotations.read(SEQUENCE, frame, "provenance")[0]


def test_a_stroke_paints_in_source_order(workspace: Workspace) -> None:
    assert paint(workspace, 0) == 600
    assert (label(workspace, 0)[WALL:] == 1).all()
    assert (label(workspace, 0)[:WALL] == 0).all()
    assert (provenance(workspace, 0)[WALL:] == 1).all()


def test_the_same_stroke_twice_is_applied_once(workspace: Workspace) -> None:
    fields = {
        "id": str(uuid.uuid4()),
        "label": 1,
        "shape": "sphere",
        "radius": 0.15,
        "samples": [{"origin": [0, 0, 1]}],
    }
    first = workspace.strokes.apply(SEQUENCE, 0, fields, "ada")
    again = workspace.strokes.apply(SEQUENCE, 0, fields, "ada")
    assert (again.edit, again.changed, again.revision) == (
        first.edit,
        first.changed,
        first.revision,
    )
    assert len([e for e in workspace.labels.edits(SEQUENCE) if e.kind == "paint"]) == 1


def test_deleted_points_are_neither_hit_nor_painted_and_can_be_restored(
    workspace: Workspace,
) -> None:
    assert paint(workspace, 0, tool="delete") == 600
    assert paint(workspace, 0) == 0
    ray = {"origin": [0, 0, 0], "direction": [0, 0, 1]}
    assert paint(workspace, 0, shape="ray", samples=[ray]) > 0
    assert (label(workspace, 0)[:WALL] == 1).any(), "the ray went through to the wall"
    assert paint(workspace, 0, tool="restore") == 600
    assert not workspace.annotations.read(SEQUENCE, 0, "deleted")[0].any()


def test_only_unlabeled_leaves_other_labels(workspace: Workspace) -> None:
    other = workspace.labels.create_label(SEQUENCE, "ada", name="other").id
    paint(workspace, 0)
    assert paint(workspace, 0, other, only_unlabeled=True) == 0
    assert paint(workspace, 0, other) == 600


def test_locked_labels_are_never_changed(workspace: Workspace) -> None:
    paint(workspace, 0)
    other = workspace.labels.create_label(SEQUENCE, "ada", name="other").id
    workspace.labels.update_label(SEQUENCE, "ada", 1, locked=True)
    assert paint(workspace, 0, other) == 0
    assert paint(workspace, 0, tool="erase") == 0
    with pytest.raises(LockedLabelError):
        paint(workspace, 1)
    with pytest.raises(LockedLabelError):
        track(workspace, labels=(1,))
    with pytest.raises(LockedLabelError):
        workspace.annotations.put(SEQUENCE, 0, np.zeros(WALL + 600, np.uint16), author="ada")


def test_a_run_is_one_edit_and_goes_with_one_undo(workspace: Workspace) -> None:
    paint(workspace, 0)
    result = track(workspace)
    assert result["frames"] == FRAMES
    for frame in range(1, FRAMES):
        assert (label(workspace, frame)[WALL:] == 1).mean() > 0.95, frame
        assert set(provenance(workspace, frame)[WALL:].tolist()) <= {0, 2}
    assert len(workspace.labels.tracks(SEQUENCE)) == FRAMES
    workspace.labels.undo(SEQUENCE, "ada")
    assert not any(label(workspace, frame).any() for frame in range(1, FRAMES))
    assert workspace.labels.tracks(SEQUENCE) == []
    assert (label(workspace, 0)[WALL:] == 1).all(), "the painted frame stays"
    workspace.labels.redo(SEQUENCE, "ada")
    assert label(workspace, FRAMES - 1).any()


def test_tracking_backward(workspace: Workspace) -> None:
    paint(workspace, FRAMES - 1)
    track(workspace, start=FRAMES - 1, stop=0)
    assert (label(workspace, 0)[WALL:] == 1).mean() > 0.95


def tracked_up_to_another(workspace: Workspace) -> int:
    """Track the first label, where another one is painted in frame 3; returns that one."""
    other = workspace.labels.create_label(SEQUENCE, "ada", name="other").id
    paint(workspace, 0)
    paint(workspace, 3, other)
    track(workspace, labels=(1,))
    return other


def test_painted_points_beat_tracked_ones(workspace: Workspace) -> None:
    other = tracked_up_to_another(workspace)
    assert (label(workspace, 3)[WALL:] == other).all()
    track(workspace, labels=(1,), overwrite="all")
    assert (label(workspace, 3)[WALL:] == 1).mean() > 0.9


def test_a_label_ends_where_it_is_lost_unless_it_is_looked_for(workspace: Workspace) -> None:
    tracked_up_to_another(workspace)
    assert not (label(workspace, 4) == 1).any()
    track(workspace, labels=(1,), continue_lost=True)
    assert (label(workspace, 4)[WALL:] == 1).mean() > 0.9


def test_a_correction_changes_no_more_than_up_to_the_next_painted_frame(
    workspace: Workspace,
) -> None:
    paint(workspace, 0)
    paint(workspace, 3)
    track(workspace, until_painted=True)
    assert (label(workspace, 2)[WALL:] == 1).mean() > 0.95
    assert not label(workspace, 4).any()


def test_a_second_run_replaces_the_first_ones_points(workspace: Workspace) -> None:
    # A run that starts from half the ball leaves no points of the run from all of it.
    paint(workspace, 0)
    track(workspace)
    before = int((label(workspace, 5) == 1).sum())
    half = {"shape": "box", "center": [-0.1, 0, 1], "size": [0.2, 1, 1], "tool": "erase"}
    paint(workspace, 0, samples=[], **half)
    track(workspace)
    assert 0 < int((label(workspace, 5) == 1).sum()) < 0.9 * before


def test_what_a_person_erased_is_not_tracked_again(workspace: Workspace) -> None:
    paint(workspace, 0)
    track(workspace)
    half = {"shape": "box", "center": [STEP * 4 - 0.1, 0, 1], "size": [0.2, 1, 1]}
    assert paint(workspace, 4, tool="erase", samples=[], **half) > 100
    erased = label(workspace, 4) == 0
    track(workspace)
    assert not label(workspace, 4)[erased].any()
    assert (label(workspace, 4) == 1).any()


def test_never_overwrites_nothing_that_has_a_label(workspace: Workspace) -> None:
    other = workspace.labels.create_label(SEQUENCE, "ada", name="other").id
    paint(workspace, 0, other)
    track(workspace)
    workspace.strokes.apply(
        SEQUENCE,
        0,
        {"label": 1, "shape": "sphere", "radius": 0.15, "samples": [{"origin": [0, 0, 1]}]},
        "ada",
    )
    track(workspace, labels=(1,), overwrite="never")
    assert (label(workspace, 4)[WALL:] == other).mean() > 0.95


def test_what_people_paint_during_a_run_stays(workspace: Workspace) -> None:
    other = workspace.labels.create_label(SEQUENCE, "ada", name="other").id
    paint(workspace, 0)

    def listen(event: Event) -> None:
        # The run has been through frame 1 by then: only its commit can still do harm there.
        if isinstance(event, Provisional) and event.frame == 2:
            paint(workspace, 1, other)

    workspace.subscribe(listen)
    track(workspace)
    assert (label(workspace, 1)[WALL:] == other).all()
    assert (label(workspace, 7)[WALL:] == 1).mean() > 0.95


@pytest.mark.parametrize("keep", [True, False])
def test_a_cancelled_run_keeps_or_drops_what_it_found(workspace: Workspace, keep: bool) -> None:
    paint(workspace, 0)
    found, ended = threading.Event(), threading.Event()
    go_on = threading.Event()

    def listen(event: Event) -> None:
        if isinstance(event, Provisional) and event.frame == 2:
            found.set()
            go_on.wait(10)
        if isinstance(event, Retracted):
            ended.set()

    workspace.subscribe(listen)
    job = workspace.tracking.start(
        SEQUENCE, TrackingRequest("icp", start=0, stop=FRAMES - 1), "ada"
    )
    assert found.wait(60)
    workspace.jobs.cancel(job.id, keep=keep)
    go_on.set()
    assert ended.wait(60)
    state = workspace.runner.wait(job.id, PATIENCE).state
    # All frames may have been found before the cancel arrived; then the run is simply done.
    if state == "cancelled":
        assert bool((label(workspace, 2) == 1).any()) is keep


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"start": 0, "stop": FRAMES}, NotFoundError),
        ({"start": 0, "stop": 0}, BadInputError),
        ({"labels": (9,)}, NotFoundError),
        ({"start": 1, "labels": (1,)}, BadInputError),
        ({"start": 1}, BadInputError),
        ({"method": "guess"}, BadInputError),
    ],
)
def test_runs_that_cannot_be_are_refused_at_once(
    workspace: Workspace, options: dict[str, object], error: type[Exception]
) -> None:
    paint(workspace, 0)
    with pytest.raises(error):
        track(workspace, **options)
    assert workspace.jobs.all() == []


def test_an_annotation_comes_back_as_it_was_put(workspace: Workspace) -> None:
    wanted = np.random.default_rng(0).integers(0, 2, WALL + 600).astype(np.uint16)
    _, revision = workspace.annotations.read(SEQUENCE, 2)
    workspace.annotations.put(SEQUENCE, 2, wanted, author="ada", if_match=revision)
    assert np.array_equal(label(workspace, 2), wanted)
    assert set(provenance(workspace, 2)[wanted > 0].tolist()) == {3}
    with pytest.raises(ConflictError):
        workspace.annotations.put(SEQUENCE, 2, wanted, author="ada", if_match=revision)
    with pytest.raises(BadInputError, match="palette"):
        workspace.annotations.put(SEQUENCE, 2, wanted * 50, author="ada")
    with pytest.raises(BadInputError, match="expected"):
        workspace.annotations.put(SEQUENCE, 2, wanted[:-1], author="ada")


def test_labels_that_came_with_the_files_are_a_first_edit(
    workspace: Workspace, tmp_path: Path
) -> None:
    xyz = np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32)
    given = np.repeat(np.array([0, 5], np.uint16), 25)
    np.savez(tmp_path / "labelled.npz", xyz=xyz, label=given)
    job = workspace.imports.begin([tmp_path / "labelled.npz"])
    assert workspace.runner.wait(job.id, PATIENCE).state == "done"
    assert np.array_equal(workspace.annotations.read("labelled", 0)[0], given)
    assert set(workspace.annotations.read("labelled", 0, "provenance")[0].tolist()) == {0, 3}
    assert [entry.id for entry in workspace.labels.palette("labelled")] == [5]


def test_exported_labels_keep_their_names_when_imported_again(
    workspace: Workspace, tmp_path: Path
) -> None:
    paint(workspace, 0)
    workspace.export(SEQUENCE, "ply", tmp_path / "again")
    job = workspace.imports.begin([tmp_path / "again"])
    assert workspace.runner.wait(job.id, PATIENCE).state == "done"
    first, again = workspace.labels.palette(SEQUENCE), workspace.labels.palette("again")
    painted = {
        int(label) for label in np.unique(workspace.annotations.read("again", 0)[0]) if label
    }
    assert painted
    for label in again:
        original = next(entry for entry in first if entry.id == label.id)
        assert (label.name, label.color) == (original.name, original.color)


def test_a_recording_without_any_point_is_refused(workspace: Workspace, tmp_path: Path) -> None:
    np.savez(tmp_path / "nothing.npz", xyz=np.empty((0, 3)))
    job = workspace.runner.wait(workspace.imports.begin([tmp_path / "nothing.npz"]).id, PATIENCE)
    assert job.state == "failed"
    assert "expected points, got none in 1 frame(s)" in str(job.error)
    assert not (workspace.library.folder / "nothing").exists()


def test_a_removed_recording_is_gone_with_its_labels(workspace: Workspace) -> None:
    paint(workspace, 0)
    workspace.deletion.delete(SEQUENCE)
    assert workspace.library.manifests() == []
    with pytest.raises(NotFoundError):
        workspace.labels.palette(SEQUENCE)
    assert [path.name for path in workspace.library.folder.iterdir()] == [".deleted"]


def test_labels_of_files_are_there_after_a_kill_between_import_and_labels(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    folder = settings.workspace / "sequences" / "marked"
    label = np.repeat(np.array([0, 7], np.uint16), [WALL, 600])
    marked = (PointFrame(frame.xyz, label=label) for frame in frames())
    import_frames(marked, folder, RecordingInfo("marked", "marked", 30))
    for _ in range(2):
        with closing(Workspace(settings)) as workspace:
            assert [entry.name for entry in workspace.labels.palette("marked")] == ["class 7"]
            assert len(workspace.labels.edits("marked")) == 1
            np.testing.assert_array_equal(workspace.annotations.read("marked", 3)[0], label)
    with closing(Workspace(settings)) as workspace:
        workspace.labels.undo("marked", "import")
    with closing(Workspace(settings)) as workspace:
        assert workspace.labels.palette("marked") == []
