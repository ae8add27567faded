"""Labels are copied from one frame to another, and cleared from several."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, LockedLabelError, NotFoundError
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.workspace import Workspace
from tests.serving import settings_in

RNG = np.random.default_rng(5)
BALL, WALL = 400, 600
WORLD = np.vstack(
    [RNG.uniform(-0.2, 0.2, (BALL, 3)) + [2, 0, 0], RNG.uniform(-1, 1, (WALL, 3)) + [6, 0, 0]]
)
IS_BALL = (np.arange(BALL + WALL) < BALL).astype(np.uint16)


def moved(frame: int) -> NDArray[np.float64]:
    """``T_world_frame``: the sensor goes 0.5 m a frame."""
    T = np.eye(4)
    T[0, 3] = 0.5 * frame
    return T


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    """Three frames of a ball before a wall; the ball is painted in the first."""
    options = settings_in(tmp_path)
    frames = (
        PointFrame((WORLD - moved(i)[:3, 3]).astype(np.float32), pose=moved(i)) for i in range(3)
    )
    folder = Path(options.workspace) / "sequences" / "room"
    folder.parent.mkdir(parents=True, exist_ok=True)
    import_frames(frames, folder, RecordingInfo("room", "room", 1.0))
    with closing(Workspace(options)) as opened:
        opened.labels.create_label("room", "me", name="ball")
        opened.annotations.put("room", 0, IS_BALL, author="me")
        yield opened


def labelled(workspace: Workspace, frame: int) -> NDArray[np.uint16]:
    return workspace.annotations.read("room", frame)[0]


def test_a_copy_follows_the_sensor_and_is_one_edit(workspace: Workspace) -> None:
    commit = workspace.copying.copy("room", 1, 0, [1], "me")
    assert np.array_equal(labelled(workspace, 1), IS_BALL)
    assert commit.changed == BALL
    workspace.labels.undo("room", "me")
    assert labelled(workspace, 1).sum() == 0


def test_a_copy_leaves_other_labels_alone(workspace: Workspace) -> None:
    workspace.labels.create_label("room", "me", name="other")
    workspace.annotations.put("room", 1, (2 * IS_BALL).astype(np.uint16), author="me")
    assert workspace.copying.copy("room", 1, 0, [1], "me").changed == 0
    with pytest.raises(BadInputError, match="another frame"):
        workspace.copying.copy("room", 1, 1, [1], "me")
    with pytest.raises(NotFoundError):
        workspace.copying.copy("room", 1, 7, [1], "me")


def test_a_range_is_cleared_of_a_label(workspace: Workspace) -> None:
    for frame in (1, 2):
        workspace.copying.copy("room", frame, 0, [1], "me")
    workspace.copying.clear("room", range(1, 3), [1], "me")
    assert [int((labelled(workspace, i) == 1).sum()) for i in range(3)] == [BALL, 0, 0]
    workspace.labels.undo("room", "me")
    assert labelled(workspace, 2).sum() == BALL
    with pytest.raises(NotFoundError):
        workspace.copying.clear("room", [0, 9], [1], "me")
    workspace.labels.update_label("room", "me", 1, locked=True)
    with pytest.raises(LockedLabelError):
        workspace.copying.clear("room", [0], [1], "me")
