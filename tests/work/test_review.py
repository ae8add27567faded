"""Doubt: a run that stops where it is unsure, and a person who vouches for what it found."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pointbrush.errors import BadInputError, LockedLabelError, NotFoundError
from pointbrush.jobs.worker import Channel
from pointbrush.labels import Write
from pointbrush.tracking import METHODS, FrameResult, Seed, TrackState
from pointbrush.values.runs import TrackingOptions
from pointbrush.work.tracking.job import TrackingWork
from pointbrush.workspace import Workspace
from tests.serving import add_sequence, settings_in

SEQUENCE = "wall"
FRAMES = 6
POINTS = np.arange(100, 200)


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    settings = settings_in(tmp_path)
    add_sequence(settings, SEQUENCE, frames=FRAMES, points=2000)
    opened = Workspace(settings)
    opened.labels.create_label(SEQUENCE, "ada", name="pin")
    yield opened
    opened.close()


def state(confidence: float, kind: str = "tracked", points: int = 100) -> TrackState:
    return TrackState(np.eye(4), 0.01, 0.9, confidence, points, kind)  # type: ignore[arg-type]


class Notes(Channel):
    """A channel that keeps what it is handed."""

    def __init__(self) -> None:
        self.frames: list[int] = []
        self.said = ""

    def item(self, value: object) -> None:
        assert isinstance(value, FrameResult)
        self.frames.append(value.frame)

    def progress(self, _fraction: float, message: str = "") -> None:
        self.said = message


@pytest.mark.parametrize(
    ("found", "stops", "last"),
    [
        (state(0.3), True, 2),
        (state(0.0, "lost", 0), True, 2),
        (state(0.3), False, FRAMES - 1),
        # Hidden for a while is no doubt, and neither is what a person painted.
        (state(0.3, "occluded", 0), True, FRAMES - 1),
        (state(0.3, "painted"), True, FRAMES - 1),
    ],
)
def test_a_run_stops_at_the_frame_it_is_unsure_of(
    workspace: Workspace,
    monkeypatch: pytest.MonkeyPatch,
    found: TrackState,
    stops: bool,
    last: int,
) -> None:
    class Doubts:
        def track(self, _frames: object, order: list[int], *_: object) -> Iterator[FrameResult]:
            for frame in order:
                yield FrameResult(frame, {1: POINTS}, {1: found if frame == 2 else state(0.9)})

    monkeypatch.setattr("pointbrush.work.tracking.job.METHODS", {**METHODS, "doubts": Doubts})
    recording = workspace.recording(SEQUENCE)
    notes = Notes()
    TrackingWork(
        recording.files,
        workspace.settings.database_url,
        0,
        FRAMES - 1,
        (Seed(1, POINTS),),
        TrackingOptions("doubts", stop_unsure=stops),
        frozenset(),
    )(notes)
    # The doubtful frame itself is found: that is where a person looks.
    assert notes.frames == list(range(last + 1))
    assert ("doubtful" in notes.said) == (last == 2)


def tracked(workspace: Workspace, confidence: float, kind: str = "tracked") -> None:
    track = {
        "label": 1, "frame": 3, "start": 0, "pose": np.eye(4).ravel().tolist(), "rmse": 0.01,
        "inliers": 0.5, "confidence": confidence, "points": len(POINTS), "state": kind,
    }  # fmt: skip
    workspace.labels.apply(
        SEQUENCE,
        edit_id="00000000-0000-4000-8000-000000000001",
        author="ada",
        kind="tracking",
        writes={3: Write(POINTS, label=1, provenance=2)} if kind == "tracked" else {},
        summary="",
        tracks=[track],
    )


def test_accepting_makes_points_painted_and_the_track_sure(workspace: Workspace) -> None:
    tracked(workspace, 0.2)
    commit = workspace.verdicts.give("accept", SEQUENCE, [3], [1], "ada")
    assert commit.changed == len(POINTS)
    values = workspace.labels.values(SEQUENCE, 3)
    assert set(np.flatnonzero(values.provenance == 1)) == set(POINTS)
    (track,) = workspace.labels.tracks(SEQUENCE)
    assert (track["state"], track["confidence"]) == ("painted", 1.0)
    # One edit, which can be taken back.
    workspace.labels.undo(SEQUENCE, "ada")
    assert (workspace.labels.values(SEQUENCE, 3).provenance[POINTS] == 2).all()
    assert workspace.labels.tracks(SEQUENCE)[0]["confidence"] == 0.2


def test_a_lost_label_is_accepted_as_not_there(workspace: Workspace) -> None:
    tracked(workspace, 0.0, "lost")
    assert workspace.verdicts.give("accept", SEQUENCE, [3], [1], "ada").changed == 0
    assert workspace.labels.tracks(SEQUENCE)[0]["state"] == "painted"


def test_a_cleared_stretch_is_empty_and_in_doubt_no_more(workspace: Workspace) -> None:
    tracked(workspace, 0.2)
    workspace.labels.apply(
        SEQUENCE,
        edit_id=None,
        author="ada",
        kind="paint",
        writes={4: Write(POINTS, label=1, provenance=1)},
        summary="",
    )
    commit = workspace.verdicts.give("clear", SEQUENCE, range(2, 5), [1], "ada")
    assert commit.changed == len(POINTS)
    assert not workspace.annotations.read(SEQUENCE, 3)[0].any()
    assert (workspace.annotations.read(SEQUENCE, 4)[0] == 1).sum() == len(POINTS), (
        "painted points stay"
    )
    (track,) = workspace.labels.tracks(SEQUENCE)
    assert (track["state"], track["confidence"], track["points"]) == ("painted", 1.0, 0)
    workspace.labels.undo(SEQUENCE, "ada")
    assert workspace.labels.tracks(SEQUENCE)[0]["confidence"] == 0.2


def test_what_cannot_be_accepted(workspace: Workspace) -> None:
    with pytest.raises(BadInputError):
        workspace.verdicts.give("accept", SEQUENCE, [3], [], "ada")
    with pytest.raises(NotFoundError):
        workspace.verdicts.give("accept", SEQUENCE, [3], [9], "ada")
    with pytest.raises(NotFoundError):
        workspace.verdicts.give("accept", SEQUENCE, [FRAMES], [1], "ada")
    workspace.labels.update_label(SEQUENCE, "ada", 1, locked=True)
    with pytest.raises(LockedLabelError):
        workspace.verdicts.give("accept", SEQUENCE, [3], [1], "ada")


def brush(label: int = 1, tool: str = "paint", **fields: object) -> dict[str, object]:
    return {"label": label, "tool": tool, "shape": "ray", "radius": 0.3, **fields}


RAY = [{"origin": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}]


def test_a_stroke_counts_what_it_will_change_and_not_what_it_only_touches(
    workspace: Workspace,
) -> None:
    def draw(**fields: object) -> tuple[int, int, int]:
        stroke = workspace.strokes.begin(SEQUENCE, 0, brush(**fields))  # type: ignore[arg-type]
        touched = stroke.add(RAY)
        assert stroke.add(RAY) == touched
        counted = stroke.changing
        return touched, counted, stroke.commit("ada").changed

    touched, counted, changed = draw()
    assert touched == counted == changed > 10
    # Painted again: touched, but nothing new to feel.
    assert draw() == (touched, 0, 0)
    other = workspace.labels.create_label(SEQUENCE, "ada", name="hand").id
    assert draw(label=other, only_unlabeled=True) == (touched, 0, 0)
    assert draw(label=other) == (touched, touched, touched)
    assert draw(tool="erase") == (touched, touched, touched)
    assert draw(tool="erase") == (touched, 0, 0)
    assert draw(tool="delete") == (touched, touched, touched)
    assert draw(tool="restore") == (touched, touched, touched)
    draw()
    workspace.labels.update_label(SEQUENCE, "ada", 1, locked=True)
    assert draw(label=other) == (touched, 0, 0)


def test_a_range_is_rejected_and_accepted_as_one_edit(workspace: Workspace) -> None:
    with pytest.raises(BadInputError, match="frames: expected at least one"):
        workspace.verdicts.give("reject", SEQUENCE, [], [1], "ada")
    with pytest.raises(NotFoundError):
        workspace.verdicts.give("accept", SEQUENCE, [0, FRAMES], [1], "ada")
