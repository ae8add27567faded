"""Hidden labels and deleted points: left alone by every shape and tool, and looked through."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pointbrush.errors import HiddenLabelError
from pointbrush.frame import FramePart, PointFrame, Sensor, join_sensors
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.workspace import Workspace
from tests.serving import settings_in

PLAIN, HIDDEN, HIDDEN_HERE, LOCKED = 1, 2, 3, 4
RNG = np.random.default_rng(0)
CLOUD = RNG.uniform(-1, 1, (700, 3)).astype(np.float32)
GRID = np.stack(np.meshgrid(np.arange(-10, 11), np.arange(-10, 11)), axis=-1).reshape(-1, 2) * 0.05
WALL = np.column_stack([GRID, np.full(len(GRID), -1.0)])
WALLS = np.concatenate([WALL, WALL - [0, 0, 1]]).astype(np.float32)
CLOUD_FRAME, WALLS_FRAME = 0, 1
SENSORS = (Sensor("front"), Sensor("rear"))
HALVES = [PointFrame(half) for half in np.split(WALLS, 2)]
RAY = {"samples": [{"origin": [0.01, 0.01, 1], "direction": [0, 0, -1]}]}
VIEW = [1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
SHAPES: dict[str, dict[str, Any]] = {
    "sphere": {**RAY, "radius": 1.3},
    "through": {**RAY, "shape": "ray", "through": True, "radius": 0.6},
    "ray": {**RAY, "radius": 0.3},
    "grow": {**RAY, "radius": 0.3},
    "plane": {**RAY, "radius": 0.3},
    "box": {"center": [0, 0, 0], "size": [1.4, 1.4, 1.4]},
    "lasso": {"polygon": [[-0.7, -0.7], [0.7, -0.7], [0.0, 0.8]], "matrix": VIEW},
}


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workspace]:
    """A recording of a cloud and of two walls, the second one behind the first.

    In another recording each wall is of another sensor.
    """
    options = settings_in(tmp_path_factory.mktemp("hidden"))
    import_frames(
        [PointFrame(CLOUD), PointFrame(WALLS)],
        options.workspace / "sequences" / "two",
        RecordingInfo("two", "two", 30),
    )
    import_frames(
        [join_sensors(SENSORS, [(FramePart(k, np.eye(4)), wall) for k, wall in enumerate(HALVES)])],
        options.workspace / "sequences" / "pair",
        RecordingInfo("pair", "pair", 30),
    )
    opened = Workspace(options)
    opened.labels.create_label("pair", "ada", name="plain")
    for name in ("plain", "hidden", "hidden here", "locked"):
        opened.labels.create_label("two", "ada", name=name)
    opened.labels.update_label("two", "ada", HIDDEN, visible=False)
    yield opened
    opened.close()


def lay(
    workspace: Workspace, frame: int, label: NDArray[np.uint16], deleted: NDArray[np.bool_]
) -> None:
    """Replace a frame's annotation: hiding does not matter to that."""
    workspace.labels.update_label("two", "ada", LOCKED, locked=False)
    workspace.annotations.put("two", frame, label, author="ada")
    workspace.annotations.put("two", frame, deleted, author="ada", layer="deleted")
    workspace.labels.update_label("two", "ada", LOCKED, locked=True)
    assert (workspace.annotations.read("two", frame)[0] == label).all()


def layers(workspace: Workspace, frame: int) -> NDArray[np.int64]:
    """Label, provenance and deletion of each point (N, 3), source order."""
    names = ("label", "provenance", "deleted")
    return np.stack(
        [workspace.annotations.read("two", frame, name)[0] for name in names], 1
    ).astype(int)


def inside(shape: str) -> NDArray[np.bool_]:
    """Points of the cloud in a shape, by its definition."""
    if shape == "sphere":
        return np.asarray(np.linalg.norm(CLOUD - [0.01, 0.01, 1], axis=1) <= 1.3)
    if shape == "through":
        off = np.linalg.norm(CLOUD[:, :2] - [0.01, 0.01], axis=1)
        return np.asarray((off <= 0.6) & (CLOUD[:, 2] <= 1))
    if shape == "box":
        return np.asarray((np.abs(CLOUD) <= 0.7).all(axis=1))
    x, y = CLOUD[:, 0], CLOUD[:, 1]
    return np.asarray((y > -0.7) & (np.abs(x) < 0.7 * (0.8 - y) / 1.5))


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from(list(SHAPES)),
    st.sampled_from(["paint", "erase", "delete", "restore"]),
    st.booleans(),
    st.booleans(),
)
def test_a_stroke_changes_what_one_sees_and_no_more(
    workspace: Workspace, seed: int, shape: str, tool: str, only_unlabeled: bool, bare: bool
) -> None:
    random = np.random.default_rng(seed)
    label = random.integers(0, 5, len(CLOUD)).astype(np.uint16)
    lay(workspace, CLOUD_FRAME, label, random.random(len(CLOUD)) < 0.2)
    before = layers(workspace, CLOUD_FRAME)
    stroke = {
        "shape": shape,
        "tool": tool,
        "label": PLAIN if tool == "paint" else 0,
        "only_unlabeled": only_unlabeled,
        "hidden": [HIDDEN_HERE, *([0] if bare else []), 60_000],
        **SHAPES[shape],
    }
    commit = workspace.strokes.apply("two", CLOUD_FRAME, stroke, "ada")
    after = layers(workspace, CLOUD_FRAME)
    hidden = [HIDDEN, HIDDEN_HERE, *([0] if bare else [])]
    free = (before[:, 2] == 0) & ~np.isin(label, [*hidden, LOCKED])
    if tool == "restore":
        free = (before[:, 2] == 1) & (label != LOCKED)
    elif only_unlabeled and tool != "erase":
        free &= label == 0
    changed = (after != before).any(axis=1)
    assert commit.changed == changed.sum()
    assert not (changed & ~free).any()
    if shape in ("sphere", "through", "box", "lasso"):
        free &= inside(shape)
        column, value = {
            "paint": (0, PLAIN),
            "erase": (0, 0),
            "delete": (2, 1),
            "restore": (2, 0),
        }[tool]
        assert (after[free, column] == value).all()
        assert not (changed & ~inside(shape)).any()


@pytest.mark.parametrize("shape", ["ray", "grow", "plane"])
@pytest.mark.parametrize("how", ["for all", "here", "deleted"])
def test_rays_fills_and_planes_go_through_what_one_does_not_see(
    workspace: Workspace, shape: str, how: str
) -> None:
    front = np.arange(len(WALLS)) < len(WALL)
    label = np.where(front, {"for all": HIDDEN, "here": HIDDEN_HERE, "deleted": 0}[how], 0)
    lay(workspace, WALLS_FRAME, label.astype(np.uint16), front & (how == "deleted"))
    stroke = {"shape": shape, "label": PLAIN, **RAY, "radius": 0.11, "hidden": [HIDDEN_HERE]}
    workspace.strokes.apply("two", WALLS_FRAME, stroke, "ada")
    painted = workspace.annotations.read("two", WALLS_FRAME)[0] == PLAIN
    assert not painted[front].any()
    assert painted[~front].sum() > 5


@pytest.mark.parametrize("shape", [*SHAPES, "object"])
def test_a_stroke_takes_no_point_of_a_hidden_sensor_and_looks_through_it(
    workspace: Workspace, shape: str
) -> None:
    deep: dict[str, dict[str, Any]] = {
        "sphere": {"radius": 3.2},
        "box": {"size": [1.4, 1.4, 5.0]},
        "lasso": {"matrix": [*VIEW[:10], 0.1, *VIEW[11:]]},
    }
    shaped = {"shape": shape, "radius": 0.11} | SHAPES.get(shape, RAY) | deep.get(shape, {})
    stroke = {"label": PLAIN, **shaped}
    front = np.arange(len(WALLS)) < len(WALL)
    for hidden, seen in (([], front), ([0], ~front)):
        workspace.annotations.put("pair", 0, np.zeros(len(WALLS), np.uint16), author="ada")
        brush = {**stroke, "hidden_sensors": hidden}
        workspace.strokes.apply("pair", 0, brush, "ada")
        painted = workspace.annotations.read("pair", 0)[0] == PLAIN
        assert painted[seen].sum() > 5
        if hidden:
            assert not painted[~seen].any()


def test_a_fill_does_not_cross_what_one_does_not_see(workspace: Workspace) -> None:
    front = np.arange(len(WALLS)) < len(WALL)
    strip = front & (np.abs(WALLS[:, 0]) < 0.12)
    lay(workspace, WALLS_FRAME, np.where(strip, HIDDEN, 0).astype(np.uint16), front & False)
    sample = {"origin": [-0.4, 0.01, 1], "direction": [0, 0, -1]}
    stroke = {"shape": "grow", "label": PLAIN, "radius": 0.11, "samples": [sample]}
    workspace.strokes.apply("two", WALLS_FRAME, stroke, "ada")
    painted = workspace.annotations.read("two", WALLS_FRAME)[0] == PLAIN
    assert painted[front & (WALLS[:, 0] < -0.12)].all()
    assert not painted[front & (WALLS[:, 0] > -0.12)].any()


def test_a_hidden_label_is_not_painted_with(workspace: Workspace) -> None:
    stroke = {"shape": "sphere", **RAY}
    for label, hidden in ((HIDDEN, []), (PLAIN, [PLAIN])):
        with pytest.raises(HiddenLabelError, match=f"\\({label}\\) is hidden; show it"):
            workspace.strokes.apply("two", 0, {**stroke, "label": label, "hidden": hidden}, "ada")
    workspace.strokes.apply("two", 0, {**stroke, "tool": "erase", "hidden": [0]}, "ada")


def test_what_is_hidden_counts_when_the_stroke_ends(workspace: Workspace) -> None:
    label = np.full(len(CLOUD), HIDDEN_HERE, np.uint16)
    lay(workspace, CLOUD_FRAME, label, np.zeros(len(CLOUD), np.bool_))
    brush = {"shape": "sphere", "label": PLAIN, "radius": 3}
    live = workspace.strokes.begin("two", CLOUD_FRAME, brush)
    assert live.add([{"origin": [0, 0, 0]}]) == live.changing == len(CLOUD)
    workspace.labels.update_label("two", "ben", HIDDEN_HERE, visible=False)
    try:
        assert live.commit("ada").changed == 0
    finally:
        workspace.labels.update_label("two", "ben", HIDDEN_HERE, visible=True)


@pytest.mark.parametrize("place", [[0, 0, 0], [900, 0, 0]])
def test_a_label_hidden_before_the_stroke_ends_is_refused(
    workspace: Workspace, place: list[float]
) -> None:
    live = workspace.strokes.begin("two", CLOUD_FRAME, {"shape": "sphere", "label": PLAIN})
    live.add([{"origin": place}])
    workspace.labels.update_label("two", "ben", PLAIN, visible=False)
    try:
        with pytest.raises(HiddenLabelError, match="is hidden; show it"):
            live.commit("ada")
    finally:
        workspace.labels.update_label("two", "ben", PLAIN, visible=True)


def test_deleted_points_come_back_whatever_label_they_hold(workspace: Workspace) -> None:
    label = np.full(len(CLOUD), HIDDEN, np.uint16)
    lay(workspace, CLOUD_FRAME, label, np.ones(len(CLOUD), np.bool_))
    stroke = {"shape": "sphere", "tool": "restore", **RAY, "radius": 9}
    assert workspace.strokes.apply("two", CLOUD_FRAME, stroke, "ada").changed == len(CLOUD)
    assert (workspace.annotations.read("two", CLOUD_FRAME)[0] == HIDDEN).all()
