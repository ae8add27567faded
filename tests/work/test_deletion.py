"""Deleting is one decision: whatever stops it, a recording is whole or can be restored."""

from __future__ import annotations

import json
import os
import signal
import time
import uuid
from collections.abc import Iterator
from contextlib import closing
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import update

from pointbrush.database import schema
from pointbrush.database.guards import EXPIRY_SECONDS
from pointbrush.errors import ConflictError, NotFoundError
from pointbrush.labels import KEPT_SECONDS
from pointbrush.labels.recordings import SURE_SECONDS, Recordings
from pointbrush.settings import Settings
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.tracking import FrameResult, TrackState
from pointbrush.work.tracking.job import PendingEdit
from pointbrush.work.trash import Trash
from pointbrush.workspace import Workspace
from tests import forked
from tests.serving import add_sequence, settings_in
from tests.waiting import PATIENCE

POINTS = 500


@pytest.fixture
def settings(tmp_path: Path, url: str) -> Settings:
    made = settings_in(tmp_path, database=url)
    add_sequence(made, "ball", frames=2, points=POINTS)
    add_sequence(made, "wall", frames=1, points=POINTS)
    return made


@pytest.fixture
def workspace(settings: Settings) -> Iterator[Workspace]:
    with closing(Workspace(settings)) as opened:
        paint(opened)
        yield opened


def paint(workspace: Workspace) -> None:
    workspace.labels.create_label("ball", "ada", name="ball")
    for label in (1, 0, 1):
        workspace.annotations.put("ball", 0, np.full(POINTS, label, np.uint16), author="ada")


def painted(workspace: Workspace, sequence: str = "ball") -> Any:
    """What people would miss: labels, history, both ways of undo."""
    labels = workspace.annotations.read(sequence, 0)[0].tolist()
    edits = [(edit.revision, edit.author, edit.undone) for edit in workspace.labels.edits(sequence)]
    return labels, [label.name for label in workspace.labels.palette(sequence)], edits


def ids(workspace: Workspace) -> list[str]:
    return [entry.id for entry in workspace.listing.all()]


def again(settings: Settings) -> None:
    """Another recording of the same name."""
    add_sequence(settings, "ball", frames=3, points=POINTS)


def test_a_deleted_recording_comes_back_with_everything(workspace: Workspace) -> None:
    before = painted(workspace)
    identity = workspace.recording("ball").identity
    workspace.deletion.delete("ball")
    assert ids(workspace) == ["wall"]
    for gone in (workspace.recording, workspace.labels.palette, workspace.deletion.delete):
        with pytest.raises(NotFoundError):
            gone("ball")
    entry = workspace.deletion.deleted()[0]
    assert entry.manifest is not None
    assert (entry.known.id, entry.known.identity, entry.manifest.frames) == ("ball", identity, 2)
    assert entry.known.until == pytest.approx(entry.known.deleted + 30 * 86_400)  # type: ignore[operator]
    assert workspace.deletion.restore("ball") == "ball"
    assert painted(workspace) == before
    assert workspace.deletion.deleted() == []
    workspace.labels.undo("ball", "ada")
    assert workspace.annotations.read("ball", 0)[0].sum() == 0
    assert workspace.listing.problems("ball") == []


def test_a_new_recording_of_the_name_has_no_old_labels(
    workspace: Workspace, settings: Settings
) -> None:
    before, identity = painted(workspace), workspace.recording("ball").identity
    workspace.deletion.delete("ball")
    again(settings)
    assert ids(workspace) == ["ball", "wall"]
    assert workspace.labels.palette("ball") == []
    assert workspace.labels.edits("ball") == []
    assert workspace.deletion.restore(identity) == "ball-2"
    assert painted(workspace, "ball-2") == before
    assert workspace.recording("ball-2").identity == identity
    assert workspace.listing.problems("ball-2") == workspace.listing.problems("ball") == []


def test_of_two_deleted_ones_the_id_means_the_last(
    workspace: Workspace, settings: Settings
) -> None:
    first = workspace.recording("ball").identity
    workspace.deletion.delete("ball")
    again(settings)
    ids(workspace)
    second = workspace.recording("ball").identity
    workspace.deletion.delete("ball")
    assert [entry.known.identity for entry in workspace.deletion.deleted()] == [second, first]
    workspace.deletion.restore("ball")
    assert workspace.recording("ball").identity == second
    workspace.deletion.restore(first)
    assert workspace.recording("ball-2").identity == first
    with pytest.raises(NotFoundError):
        workspace.deletion.restore("ball")


def age(workspace: Workspace, seconds: float) -> None:
    """Let all times of deleted recordings lie further back."""
    columns = schema.sequences.c
    earlier = {"deleted": columns.deleted - seconds, "expired": columns.expired - seconds}
    with workspace.labels.database.write() as connection:
        connection.execute(update(schema.sequences).values(earlier))


def test_after_30_days_nothing_is_left(workspace: Workspace, settings: Settings) -> None:
    workspace.deletion.delete("ball")
    age(workspace, KEPT_SECONDS + 1)
    with pytest.raises(NotFoundError):
        workspace.deletion.restore("ball")
    age(workspace, SURE_SECONDS)
    with closing(Workspace(settings)) as reopened:
        assert reopened.deletion.deleted() == []
    kept = [path for path in (workspace.library.folder / ".deleted").iterdir() if path.is_dir()]
    assert kept == []


def test_a_clock_that_jumped_purges_nothing(workspace: Workspace) -> None:
    before = painted(workspace)
    workspace.deletion.delete("ball")
    for _ in range(2):  # a month ahead, looked at, and set right again
        age(workspace, KEPT_SECONDS + 1)
        assert len(workspace.deletion.deleted()) == 1
        age(workspace, -KEPT_SECONDS - 1)
        assert len(workspace.deletion.deleted()) == 1
        age(workspace, SURE_SECONDS)
    assert workspace.deletion.restore("ball") == "ball"
    assert painted(workspace) == before


def test_a_stroke_of_before_does_not_reach_the_new_recording(
    workspace: Workspace, settings: Settings
) -> None:
    live = workspace.strokes.begin("ball", 0, {"tool": "erase", "shape": "sphere", "radius": 9.0})
    live.add([{"origin": [0, 0, 3]}])
    workspace.deletion.delete("ball")
    with pytest.raises(NotFoundError, match="deleted"):
        live.commit("ada")
    again(settings)
    ids(workspace)
    with pytest.raises(NotFoundError, match="deleted"):
        live.commit("ada")


def test_labels_whose_recording_was_replaced_are_kept_aside(
    workspace: Workspace, settings: Settings, tmp_path: Path
) -> None:
    before = painted(workspace)
    folder = workspace.library.folder / "ball"
    folder.rename(tmp_path / "ball")
    again(settings)
    with closing(Workspace(settings)) as reopened:
        assert reopened.labels.palette("ball") == []
        aside = next(entry for entry in reopened.listing.all() if entry.id not in ("ball", "wall"))
        assert aside.damaged is not None
        assert "labels without their recording" in aside.damaged
        reopened.deletion.delete("ball")
    (tmp_path / "ball").rename(folder)
    with closing(Workspace(settings)) as reopened:
        assert painted(reopened) == before
        assert [entry.damaged for entry in reopened.listing.all()] == [None, None]


def killed(settings: Settings, act: str, place: str) -> None:
    """Do ``act`` and die by SIGKILL at ``place``."""
    workspace = Workspace(settings)
    kind, name, when = place.split(".")
    owner: Any = {"Recordings": Recordings, "Trash": Trash}[kind]
    was = getattr(owner, name)

    def stop(*args: object) -> None:
        if when == "after":
            was(*args)
        os.kill(os.getpid(), signal.SIGKILL)

    setattr(owner, name, stop)
    getattr(workspace.deletion, act)("ball")


def kill_in(settings: Settings, act: str, place: str) -> None:
    assert forked.call(killed, settings, act, place) == -signal.SIGKILL


def test_killed_at_any_step_of_deleting(settings: Settings) -> None:
    with closing(Workspace(settings)) as workspace:
        paint(workspace)
        before, identity = painted(workspace), workspace.recording("ball").identity
    for place, deleted in (
        ("Recordings.delete.before", False),
        ("Recordings.delete.after", True),
        ("Trash.move_to_trash.after", True),
    ):
        kill_in(settings, "delete", place)
        with closing(Workspace(settings)) as workspace:
            assert ("ball" in ids(workspace)) == (not deleted), place
            if deleted:
                again(settings)
                ids(workspace)
                assert workspace.labels.palette("ball") == []
                workspace.deletion.delete("ball")
                assert workspace.deletion.restore(identity) == "ball"
            assert painted(workspace) == before, place
            assert workspace.listing.problems("ball") == []


def test_killed_at_any_step_of_restoring(settings: Settings) -> None:
    with closing(Workspace(settings)) as workspace:
        paint(workspace)
        before = painted(workspace)
    for place, restored in (
        ("Recordings.restore.before", False),
        ("Recordings.restore.after", True),
        ("Trash.move_back.after", True),
    ):
        with closing(Workspace(settings)) as workspace:
            if "ball" in ids(workspace):
                workspace.deletion.delete("ball")
        kill_in(settings, "restore", place)
        with closing(Workspace(settings)) as workspace:
            assert ("ball" in ids(workspace)) == restored, place
            if not restored:
                assert workspace.deletion.restore("ball") == "ball"
            assert painted(workspace) == before, place


def test_who_has_it_open_elsewhere_sees_it_go_and_come(
    workspace: Workspace, settings: Settings
) -> None:
    before = painted(workspace)
    with closing(Workspace(settings)) as there:
        assert painted(there) == before
        workspace.deletion.delete("ball")
        with pytest.raises(NotFoundError):
            there.labels.palette("ball")
        with pytest.raises(NotFoundError):
            there.annotations.put("ball", 0, np.ones(POINTS, np.uint16), author="eve")
        assert ids(there) == ["wall"]
        there.deletion.restore("ball")
        assert painted(workspace) == before


def test_what_is_worked_on_is_not_deleted(workspace: Workspace, settings: Settings) -> None:
    with closing(Workspace(settings)) as there:
        guard = there.labels.guards.begin("ball", "tracking")
        with pytest.raises(ConflictError, match="is being tracked"):
            workspace.deletion.delete("ball")
        assert "ball" in ids(workspace)
        there.labels.guards.end(guard)
    workspace.deletion.delete("ball")


def test_a_run_of_before_writes_nothing_into_the_new_recording(
    workspace: Workspace, settings: Settings
) -> None:
    identity = workspace.recording("ball").identity
    pending = PendingEdit(workspace.labels, "ball", identity, 0, (1,), "tracked")
    track = TrackState(np.eye(4), 0.0, 1.0, 1.0, 3, "tracked")
    pending.results.append(FrameResult(1, {1: np.arange(3)}, {1: track}))
    workspace.deletion.delete("ball")
    with pytest.raises(NotFoundError, match="deleted"):
        pending.commit(str(uuid.uuid4()), "ada", "tracked")
    again(settings)
    ids(workspace)
    with pytest.raises(NotFoundError, match="deleted"):
        pending.commit(str(uuid.uuid4()), "ada", "tracked")
    assert workspace.labels.edits("ball") == []


def test_work_on_another_machine_guards_until_it_is_silent(workspace: Workspace) -> None:
    workspace.labels.guards.begin("ball", "tracking")
    database = workspace.labels.database
    with database.write() as connection:
        connection.execute(update(schema.works).values(host="elsewhere", process=1))
    with pytest.raises(ConflictError, match="by process 1 on elsewhere"):
        workspace.deletion.delete("ball")
    with database.write() as connection:
        silent = schema.works.c.beat - EXPIRY_SECONDS - 1
        connection.execute(update(schema.works).values(beat=silent))
    workspace.deletion.delete("ball")


def guard(database: str) -> None:
    WorkspaceStore(database).guards.begin("ball", "tracking")
    print("begun", flush=True)
    time.sleep(PATIENCE)


def test_work_of_a_process_that_was_killed_guards_nothing(
    workspace: Workspace, settings: Settings
) -> None:
    with forked.calling(guard, settings.database) as process:
        assert process.stdout.readline() == "begun\n"
        with pytest.raises(ConflictError, match="is being tracked"):
            workspace.deletion.delete("ball")
    workspace.deletion.delete("ball")


def import_at_once(settings: Settings, source: Path, both: Barrier) -> None:
    with closing(Workspace(settings)) as workspace:
        both.wait()
        begun = workspace.imports.begin([source], name="Twice")
        job = workspace.runner.wait(begun.id, PATIENCE)
        print(json.dumps([job.state, job.error, job.result]))


def test_one_name_imported_on_two_servers_at_once_gives_two_recordings(
    settings: Settings, tmp_path: Path
) -> None:
    np.save(tmp_path / "cloud.npy", np.random.default_rng(0).random((400, 3)).astype(np.float32))
    given = (settings, tmp_path / "cloud.npy", forked.FORKSERVER.Barrier(2))
    with (
        forked.calling(import_at_once, *given) as one,
        forked.calling(import_at_once, *given) as other,
    ):
        ended = [json.loads(process.stdout.readline()) for process in (one, other)]
    assert [state for state, _, _ in ended] == ["done", "done"], ended
    assert sorted(result["sequence"] for _, _, result in ended) == ["twice", "twice-2"], ended
    with closing(Workspace(settings)) as workspace:
        for sequence in ("twice", "twice-2"):
            assert workspace.listing.problems(sequence) == []
            assert workspace.recording(sequence).manifest.points == [400]
