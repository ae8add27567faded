"""A stroke on frames that are laid over one another: their poses and tracks, and one edit."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.errors import ConflictError, NotFoundError
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.workspace import Workspace
from tests.serving import settings_in

RNG = np.random.default_rng(3)
FRAMES, PARKED, CAR, WALL = 5, 300, 200, 2_000
SHOWN = 2
AWAY = np.array([0.0, 0.0, 0.0])
PARKED_WORLD = RNG.uniform(-0.5, 0.5, (PARKED, 3)) + [4, 0, 0.5]
WALL_WORLD = np.column_stack(
    [RNG.uniform(0, 10, WALL), np.full(WALL, 3.0), RNG.uniform(0, 3, WALL)]
)
CAR_OWN = RNG.uniform(-0.4, 0.4, (CAR, 3)) + [0, 0, 0.5]


def pose(frame: int) -> NDArray[np.float64]:
    """``T_world_frame``: the sensor drives 1 m a frame and turns 10 degrees."""
    turn = np.radians(10 * frame)
    T = np.eye(4)
    T[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    T[:3, 3] = [frame, 0.2 * frame, 0.1]
    return T


def car_world(frame: int) -> NDArray[np.float64]:
    """``T_world_car``: another car drives 2 m a frame."""
    T = np.eye(4)
    T[:3, 3] = [2.0 * frame, -3, 0]
    return T


def seen(frame: int) -> NDArray[np.float64]:
    """Points of the frame in its own coordinates: the parked car, a wall, the car that drives."""
    car = CAR_OWN + car_world(frame)[:3, 3]
    world = np.concatenate([PARKED_WORLD, WALL_WORLD, car])
    T = np.linalg.inv(pose(frame))
    return np.asarray(world @ T[:3, :3].T + T[:3, 3] + AWAY)


IS_PARKED = np.arange(PARKED + WALL + CAR) < PARKED
IS_CAR = np.arange(PARKED + WALL + CAR) >= PARKED + WALL


@pytest.fixture(params=["sqlite", "postgresql"])
def workspace(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Workspace]:
    """A street, seen from a car that drives; and a recording without poses."""
    options = settings_in(tmp_path)
    if request.param == "postgresql":
        options = settings_in(tmp_path, database=request.getfixturevalue("labels_url"))
    for name, poses in (("street", True), ("room", False)):
        import_frames(
            (
                PointFrame(seen(i).astype(np.float32), pose=pose(i) if poses else None)
                for i in range(FRAMES)
            ),
            options.workspace / "sequences" / name,
            RecordingInfo(name, name, 10),
        )
    opened = Workspace(options)
    for name in ("street", "room"):
        opened.labels.create_label(name, "ada", name="parked")
        opened.labels.create_label(name, "ada", name="moving")
    yield opened
    opened.close()


def labels(workspace: Workspace, frame: int, sequence: str = "street") -> NDArray[np.uint16]:
    return np.asarray(workspace.annotations.read(sequence, frame)[0])


def in_shown(world: list[float]) -> list[float]:
    """A place of the world in the shown frame's coordinates."""
    T = np.linalg.inv(pose(SHOWN))
    return (T[:3, :3] @ np.array(world) + T[:3, 3]).tolist()


def stroke(**fields: Any) -> dict[str, Any]:
    return {
        "id": str(uuid.uuid4()),
        "label": 1,
        "shape": "sphere",
        "radius": 1.0,
        "samples": [{"origin": in_shown([4, 0, 0.5])}],
        "frames": list(range(FRAMES)),
        **fields,
    }


ABOVE = {"origin": in_shown([4, 0, 8]), "direction": [0.0, 0.0, -1.0]}
TURN = np.radians(-10 * SHOWN)
SHAPES: dict[str, dict[str, Any]] = {
    "sphere": {},
    "ray": {"shape": "ray", "samples": [ABOVE], "radius": 1.2},
    "through": {"shape": "ray", "through": True, "samples": [ABOVE], "radius": 1.0},
    "box": {
        "shape": "box",
        "samples": [],
        "center": in_shown([4, 0, 0.5]),
        "size": [1.05, 1.05, 1.05],
        "quaternion": [0, 0, np.sin(TURN / 2), np.cos(TURN / 2)],
    },
    "grow": {"shape": "grow", "samples": [ABOVE], "radius": 0.6},
}


def test_a_parked_car_is_labelled_in_all_frames_by_one_stroke(workspace: Workspace) -> None:
    for done, shape in enumerate(SHAPES, start=1):
        sent = stroke(**SHAPES[shape])
        commit = workspace.strokes.apply("street", SHOWN, sent, "ada")
        for frame in range(FRAMES):
            found = labels(workspace, frame) == 1
            assert not found[~IS_PARKED].any(), shape
            # A region by normals leaves some of a heap of random points out; the rest is exact.
            assert found[IS_PARKED].mean() > 0.8, shape
        assert sorted(commit.frames) == list(range(FRAMES))
        again = workspace.strokes.apply("street", SHOWN, sent, "ada")
        assert (again.revision, again.changed) == (commit.revision, commit.changed)
        assert len([e for e in workspace.labels.edits("street") if e.kind == "paint"]) == done
        workspace.labels.undo("street", "ada")
        assert not any(labels(workspace, frame).any() for frame in range(FRAMES))
    workspace.labels.redo("street", "ada")
    assert all(labels(workspace, frame).any() for frame in range(FRAMES))


def test_a_lasso_takes_what_it_encloses_of_every_frame(workspace: Workspace) -> None:
    looks_down = np.diag([0.05, 0.05, 0.05, 1.0])
    x, y, _ = (0.05 * np.array(in_shown([4, 0, 0.5]))).tolist()
    square = [[x + 0.05 * a, y + 0.05 * b] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    workspace.strokes.apply(
        "street",
        SHOWN,
        stroke(shape="lasso", samples=[], polygon=square, matrix=looks_down.ravel().tolist()),
        "ada",
    )
    for frame in range(FRAMES):
        assert (labels(workspace, frame) == 1).tolist() == IS_PARKED.tolist()


def test_only_the_frames_named_and_the_own_one_are_painted(workspace: Workspace) -> None:
    commit = workspace.strokes.apply("street", SHOWN, stroke(frames=[1, 1, 3]), "ada")
    assert sorted(commit.frames) == [1, 2, 3]
    assert [edit.summary for edit in workspace.labels.edits("street", limit=1)] == [
        "paint 900 points as 'parked' in 3 frames"
    ]


def test_a_tracked_object_lies_where_it_is_in_the_frame_shown(workspace: Workspace) -> None:
    tracks = [
        {
            "label": 2,
            "frame": frame,
            "start": 0,
            "pose": (np.linalg.inv(pose(frame)) @ car_world(frame) @ pose(0)).ravel().tolist(),
            "state": "tracked" if frame != 4 else "lost",
        }
        for frame in range(FRAMES)
    ]
    for frame in range(FRAMES):
        workspace.annotations.put("street", frame, np.where(IS_CAR, 2, 0).astype(np.uint16), author="ada")  # fmt: skip  # noqa: E501
    workspace.labels.apply(
        "street", edit_id=None, author="ada", kind="tracking", writes={}, summary="", tracks=tracks
    )
    at_car = {"samples": [{"origin": in_shown([2.0 * SHOWN, -3, 0.5])}], "radius": 0.9}
    workspace.strokes.apply("street", SHOWN, stroke(**at_car), "ada")
    for frame in range(FRAMES - 1):
        assert (labels(workspace, frame)[IS_CAR] == 1).all(), frame
        assert not (labels(workspace, frame)[~IS_CAR] == 1).any(), frame
    # Where the track was lost the points lie by the poses, elsewhere in the street.
    assert not (labels(workspace, 4)[IS_CAR] == 1).any()


def test_a_ray_stops_at_what_another_frame_shows_in_front(workspace: Workspace) -> None:
    # The car that drives stands between the sensor and the wall in frame 0 only.
    toward = {"origin": in_shown([0, -8, 0.5]), "direction": (np.linalg.inv(pose(SHOWN))[:3, :3] @ [0, 1, 0]).tolist()}  # fmt: skip  # noqa: E501
    workspace.strokes.apply(
        "street", SHOWN, stroke(shape="ray", samples=[toward], radius=0.3), "ada"
    )
    assert (labels(workspace, 0)[IS_CAR] == 1).any()
    for frame in range(FRAMES):
        assert not (labels(workspace, frame)[~IS_CAR] == 1).any()


def test_an_object_is_taken_in_every_frame(workspace: Workspace) -> None:
    commit = workspace.strokes.apply(
        "street",
        SHOWN,
        stroke(shape="object", samples=[{**ABOVE}], level=None, only_unlabeled=True),
        "ada",
    )
    assert sorted(commit.frames) == list(range(FRAMES))
    shown = labels(workspace, SHOWN) == 1
    for frame in range(FRAMES):
        assert ((labels(workspace, frame) == 1) == shown).mean() > 0.99


def test_a_recording_without_poses_stands_still(workspace: Workspace) -> None:
    at = seen(SHOWN)[IS_PARKED].mean(axis=0).tolist()
    workspace.strokes.apply("room", SHOWN, stroke(samples=[{"origin": at}], radius=0.3), "ada")
    for frame in range(FRAMES):
        inside = np.linalg.norm(seen(frame) - at, axis=1) < 0.3
        found = labels(workspace, frame, "room") == 1
        assert (found != inside).sum() <= 1


def test_frames_that_cannot_be_painted_are_refused_in_words(workspace: Workspace) -> None:
    with pytest.raises(NotFoundError, match="frames 0 to 4, got 9"):
        workspace.strokes.apply("street", SHOWN, stroke(frames=[9]), "ada")
    workspace.labels.update_label("street", "ada", 1, locked=True)
    with pytest.raises(ConflictError):
        workspace.strokes.apply("street", SHOWN, stroke(), "ada")
    assert not any(labels(workspace, frame).any() for frame in range(FRAMES))
