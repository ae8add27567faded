"""Pointing at the floor: the recording stands there, whatever was detected, and can go back."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.sequences.storage.manifest import FILE, checksum
from pointbrush.workspace import Workspace
from tests.serving import settings_in

FAR = np.array([448_000.0, 5_411_000.0, 30.0])
TURN = Rotation.from_euler("xyz", [20, -15, 40], degrees=True)
"""How crooked the hall lies in its file, and how far from the file's origin."""
EYE = np.array([0.0, 0.0, 1.6])


def hall() -> NDArray[np.float64]:
    """A floor (z = 0) of 5 by 6 m, a wall and a table, z up."""
    rng = np.random.default_rng(0)
    floor = rng.uniform([-2.5, -3, 0], [2.5, 3, 0], (9000, 3))
    wall = rng.uniform([-2.5, 3, 0], [2.5, 3, 2.6], (6000, 3))
    table = rng.uniform([0.5, 1, 0.75], [2, 2, 0.75], (2000, 3))
    parts = np.concatenate([floor, wall, table])
    noisy: NDArray[np.float64] = parts + rng.normal(0, 0.006, parts.shape)
    return noisy


def ray(place: list[float]) -> dict[str, list[float]]:
    """From the eyes of somebody in the hall to a place of it, in the file's coordinates."""
    way = TURN.apply(np.subtract(place, EYE))
    return {"origin": (TURN.apply(EYE) + FAR).tolist(), "direction": way.tolist()}


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    settings = settings_in(tmp_path)
    frame = PointFrame(TURN.apply(hall()) + FAR)
    folder = settings.workspace / "sequences" / "hall"
    import_frames([frame], folder, RecordingInfo("hall", "hall", 30))
    # Detected with a lean, as if a slope outside had been taken for the floor.
    opened = Workspace(settings)
    lean = Rotation.from_euler("x", 8, degrees=True).as_matrix()
    room = opened.recording("hall").manifest.T_room_local
    room[:3] = lean @ room[:3]
    opened.update_sequence("hall", room=room)
    yield opened
    opened.close()


def floor_in_room(workspace: Workspace) -> NDArray[np.float64]:
    """Where the floor's true corners are in the room now."""
    manifest = workspace.recording("hall").manifest
    corners = np.array([[x, y, 0.0] for x in (-2.5, 2.5) for y in (-3, 3)])
    local = TURN.apply(corners) + FAR - manifest.shift
    T_room_local = manifest.T_room_local
    placed: NDArray[np.float64] = local @ T_room_local[:3, :3].T + T_room_local[:3, 3]
    return placed


@pytest.mark.parametrize(
    ("places", "slack"),
    [
        ([[0.5, -1.0, 0.0]], 0.06),
        ([[-1.5, -2.0, 0.0], [2.0, 0.5, 0.0]], 0.04),
        ([[-2.0, -2.5, 0.0], [2.0, -2.5, 0.0], [0.0, 2.5, 0.0]], 0.02),
    ],
    ids=["one place", "two places", "three places"],
)
def test_the_floor_pointed_at_is_the_rooms_floor(
    workspace: Workspace, places: list[list[float]], slack: float
) -> None:
    before = floor_in_room(workspace)
    assert np.abs(before[:, 1]).max() > 0.2
    workspace.stand_on_floor("hall", 0, [ray(place) for place in places])
    after = floor_in_room(workspace)
    assert np.abs(after[:, 1]).max() < slack
    # The recording is neither turned about, nor scaled; what was pointed at stays where it was.
    headings = [np.arctan2(*(corners[3] - corners[0])[[0, 2]]) for corners in (before, after)]
    assert headings[1] == pytest.approx(headings[0], abs=0.05)
    T_room_local = workspace.recording("hall").manifest.T_room_local
    assert T_room_local[:3, :3] @ T_room_local[:3, :3].T == pytest.approx(np.eye(3))
    # Up is where one looked from.
    local = TURN.apply(EYE) + FAR - workspace.recording("hall").manifest.shift
    assert T_room_local[1, :3] @ local + T_room_local[1, 3] == pytest.approx(1.6, abs=slack)


def test_a_wall_that_is_a_floor_becomes_one_and_the_import_can_be_had_back(
    workspace: Workspace,
) -> None:
    found = workspace.recording("hall").manifest.found_room
    workspace.stand_on_floor("hall", 0, [ray([-1.0, 3.0, 1.3])])
    T_room_local = workspace.recording("hall").manifest.T_room_local
    into = TURN.apply([0.0, -1.0, 0.0])
    assert T_room_local[:3, :3] @ into == pytest.approx([0, 1, 0], abs=0.02)
    assert workspace.reset_floor("hall").room == found
    # Another server, or this one another day.
    assert workspace.recording("hall").manifest.room == found


def test_what_is_deleted_is_no_floor(workspace: Workspace) -> None:
    way = ray([1.2, 1.5, 0.75])
    workspace.stand_on_floor("hall", 0, [way])
    assert floor_in_room(workspace)[:, 1] == pytest.approx(-0.75, abs=0.06)
    away = {"tool": "delete", "shape": "plane", "radius": 0.1, "samples": [way]}
    workspace.strokes.apply("hall", 0, away, "ada")
    workspace.stand_on_floor("hall", 0, [way])
    assert np.abs(floor_in_room(workspace)[:, 1]).max() < 0.1


def test_rays_that_meet_nothing_change_nothing(workspace: Workspace) -> None:
    before = workspace.recording("hall").manifest.room
    with pytest.raises(BadInputError, match="meets a surface, got none in 1"):
        workspace.stand_on_floor("hall", 0, [ray([0, 0, 0]), ray([0, 0, 9])])
    with pytest.raises(BadInputError, match="at least one"):
        workspace.stand_on_floor("hall", 0, [])
    with pytest.raises(NotFoundError):
        workspace.stand_on_floor("hall", 1, [ray([0, 0, 0])])
    assert workspace.recording("hall").manifest.room == before


def test_an_import_of_before_this_goes_back_to_where_it_stood(workspace: Workspace) -> None:
    path = workspace.library.folder / "hall" / FILE
    content = json.loads(path.read_text())
    del content["found_room"], content["checksum"]
    path.write_text(json.dumps(content | {"checksum": checksum(content)}))
    assert workspace.recording("hall").manifest.found_room == content["room"]
