"""What a run may change, whatever is written already and whatever the frames are like."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pointbrush.errors import BadInputError, LockedLabelError, NotFoundError, PointbrushError
from pointbrush.frame import PointFrame
from pointbrush.jobs.worker import Channel
from pointbrush.labels import Write
from pointbrush.labels.types import FrameValues
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.tracking import FrameResult
from pointbrush.values.runs import TrackingOptions, TrackingRequest
from pointbrush.work.tracking.job import LEAD, PendingEdit, TrackingWork, lead, prepare
from pointbrush.workspace import Workspace
from tests.serving import settings_in

METHODS = ("icp", "color-icp", "auto")
KINDS = ("ball", "ball", "empty", "few", "same", "ball", "ball")
BALL, OTHER, LOCKED = 1, 2, 3
PAINTED = 1
RECORDINGS = ("coloured", "plain")


def frame(kind: str, number: int, coloured: bool) -> PointFrame:
    """A ball that moves before a wall; or nothing, 50 points, 200 points in one place."""
    rng = np.random.default_rng(number)
    wall = np.column_stack([rng.uniform(-1, 1, (250, 2)), rng.normal(3, 0.002, 250)])
    ball = rng.normal(size=(150, 3))
    ball *= 0.15 / np.linalg.norm(ball, axis=1, keepdims=True)
    xyz = np.concatenate([wall, ball + [0.03 * number, 0, 2]])
    if kind == "same":
        xyz = np.full((200, 3), 2.0)
    xyz = xyz[rng.permutation(len(xyz))][: {"empty": 0, "few": 50}.get(kind)]
    rgb = rng.integers(0, 255, (len(xyz), 3)).astype(np.uint8) if coloured else None
    return PointFrame(xyz=xyz.astype(np.float32), rgb=rgb)


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workspace]:
    chosen = settings_in(tmp_path_factory.mktemp("runs"))
    for name in RECORDINGS:
        import_frames(
            (frame(kind, i, name == "coloured") for i, kind in enumerate(KINDS)),
            chosen.workspace / "sequences" / name,
            RecordingInfo(name, name, 30),
        )
    opened = Workspace(chosen)
    for name in RECORDINGS:
        for label in ("ball", "other", "locked"):
            opened.labels.create_label(name, "ada", name=label)
    yield opened
    opened.close()


@dataclass
class Notes(Channel):
    """A channel that keeps what it is handed."""

    found: list[FrameResult]

    def item(self, value: object) -> None:
        assert isinstance(value, FrameResult)
        self.found.append(value)

    def progress(self, _fraction: float, _message: str = "") -> None:
        return None


@dataclass
class Request:
    """A run that somebody asks for."""

    sequence: str
    start: int
    stop: int
    method: str
    overwrite: Literal["never", "tracked", "all"]
    labels: list[int] | None
    continue_lost: bool = True


def annotate(workspace: Workspace, sequence: str, seed: int, share: float) -> None:
    """Random labels, provenance and deleted points in every frame, some of them locked."""
    rng = np.random.default_rng(seed)
    writes = {}
    recording = workspace.recording(sequence)
    for number in range(len(KINDS)):
        stored = recording[number]
        count = len(stored.xyz)
        label = np.where(rng.random(count) < share, rng.integers(0, 4, count), 0)
        provenance = np.where(label > 0, rng.integers(1, 4, count), rng.random(count) < 0.1)
        if number % 3 == 0 and count > 200:
            ball = np.linalg.norm(stored.xyz - [0.03 * number, 0, 2], axis=1) < 0.2
            label, provenance = np.where(ball, BALL, label), np.where(ball, PAINTED, provenance)
        writes[number] = Write(
            np.arange(count),
            label=label.astype(np.uint16),
            provenance=provenance.astype(np.uint8),
            deleted=rng.random(count) < 0.1,
        )
    workspace.labels.update_label(sequence, "ada", LOCKED, locked=False)
    workspace.labels.apply(
        sequence, edit_id=str(uuid.uuid4()), author="ada", kind="paint", writes=writes, summary=""
    )
    workspace.labels.update_label(sequence, "ada", LOCKED, locked=True)


def written(workspace: Workspace, sequence: str) -> list[FrameValues]:
    return [workspace.labels.values(sequence, i) for i in range(len(KINDS))]


def same(one: FrameValues, other: FrameValues, where: np.ndarray | slice = slice(None)) -> bool:
    return all(
        np.array_equal(getattr(one, layer)[where], getattr(other, layer)[where])
        for layer in ("label", "provenance", "deleted")
    )


def results_of(workspace: Workspace, asked: Request) -> list[FrameResult]:
    recording = workspace.recording(asked.sequence)
    seeds = prepare(workspace.labels, recording, asked.labels, asked.start, asked.stop)
    notes = Notes([])
    TrackingWork(
        recording.files,
        workspace.settings.database_url,
        asked.start,
        asked.stop,
        seeds,
        TrackingOptions(asked.method, asked.overwrite, continue_lost=asked.continue_lost),
        frozenset({LOCKED}),
    )(notes)
    return notes.found


def plain(found: FrameResult) -> list[object]:
    points = [(label, numbers.tobytes()) for label, numbers in found.assignments.items()]
    states = [
        (label, s.pose.tobytes(), s.rmse, s.inliers, s.confidence, s.points, s.state)
        for label, s in found.tracks.items()
    ]
    return [found.frame, points, states]


requests = st.builds(
    Request,
    sequence=st.sampled_from(RECORDINGS),
    start=st.integers(0, len(KINDS) - 1),
    stop=st.integers(0, len(KINDS) - 1),
    method=st.sampled_from(METHODS),
    overwrite=st.sampled_from(["never", "tracked", "all"]),
    labels=st.sampled_from([None, [BALL], [BALL, OTHER]]),
    continue_lost=st.booleans(),
)


@settings(
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(asked=requests, seed=st.integers(0, 99), share=st.sampled_from([0.0, 0.05, 0.5]))
def test_a_run_changes_only_what_it_may(
    workspace: Workspace, asked: Request, seed: int, share: float
) -> None:
    annotate(workspace, asked.sequence, seed, share)
    before = written(workspace, asked.sequence)
    try:
        found = results_of(workspace, asked)
    except PointbrushError:
        # Refused before it began: nothing to track there, or no way to go.
        alive = ~before[asked.start].deleted
        present = set(before[asked.start].label[alive].tolist()) - {0, LOCKED}
        assert asked.start == asked.stop or not present.issuperset(asked.labels or present or {0})
        return
    again = results_of(workspace, asked)
    assert list(map(plain, found)) == list(map(plain, again))
    labels = tuple(found[0].tracks)
    pending = PendingEdit(
        workspace.labels,
        asked.sequence,
        workspace.recording(asked.sequence).identity,
        asked.start,
        labels,
        asked.overwrite,
        found,
    )
    done = pending.commit(str(uuid.uuid4()), "ada", "")
    after = written(workspace, asked.sequence)
    reached = {result.frame for result in found} - {asked.start}
    for number, (old, new) in enumerate(zip(before, after, strict=True)):
        if number not in reached:
            assert same(old, new)
            continue
        kept = old.label == LOCKED
        if asked.overwrite != "all":
            kept |= old.provenance == PAINTED
        if asked.overwrite == "never":
            kept |= old.label > 0
        assert same(old, new, kept)
        assert np.array_equal(old.deleted, new.deleted)
        changed = old.label != new.label
        assert set(new.label[changed].tolist()) <= {0, *labels}
        assert not new.label[changed & old.deleted].any()
    assert done["edit"] is not None
    workspace.labels.undo(asked.sequence, "ada")
    assert all(map(same, before, written(workspace, asked.sequence)))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"start": 2}, BadInputError),
        ({"labels": (OTHER,)}, BadInputError),
        ({"labels": (LOCKED,)}, LockedLabelError),
        ({"labels": (99,)}, NotFoundError),
        ({"stop": 7}, NotFoundError),
        ({"start": -1}, NotFoundError),
        ({"stop": 0}, BadInputError),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else value.__name__,
)
def test_what_cannot_be_tracked_is_refused_before_it_begins(
    workspace: Workspace, method: str, change: dict[str, object], error: type[Exception]
) -> None:
    annotate(workspace, "plain", seed=0, share=0.0)
    before = written(workspace, "plain")
    body = TrackingRequest(**{"start": 0, "stop": 3, "method": method, "labels": (BALL,)} | change)  # type: ignore[arg-type]
    with pytest.raises(error):
        workspace.tracking.start("plain", body, "ada")
    assert all(map(same, before, written(workspace, "plain")))


def test_a_run_looks_back_to_where_its_labels_were_painted() -> None:
    tracked, painted = (100, 0), (100, 100)
    counts = {(i, label): tracked for i in range(60) for label in (1, 2)}
    assert lead(counts, [1, 2], list(range(50, 60)), 60) == tuple(range(50 - LEAD, 50))
    counts[45, 1] = painted
    assert lead(counts, [1], list(range(50, 60)), 60) == tuple(range(45, 50))
    assert len(lead(counts, [1, 2], list(range(50, 60)), 60)) == LEAD
    assert lead(counts, [1], [10, 9, 8], 13) == (12, 11)
    assert lead(counts, [3], list(range(50, 60)), 60) == ()
    assert lead(counts, [1], [0, 1], 60) == ()
