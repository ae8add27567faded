"""Frames laid over one another, over REST: where they lie, and a stroke that paints them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pointbrush.client import Client
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from tests.serving import TOKEN, serving, settings_in

FAR = np.array([500_000.0, 4_600_000.0, 200.0])


def pose(frame: int) -> np.ndarray:
    """``T_world_frame`` of a sensor that turns by a quarter each frame, far from the origin."""
    T = np.eye(4)
    T[:2, :2] = [[[1, 0], [0, 1]], [[0, -1], [1, 0]], [[-1, 0], [0, -1]]][frame]
    T[:3, 3] = FAR - T[:3, :3] @ FAR + [frame, 0, 0]
    return T


def test_strokes_lie_where_the_placements_say_also_far_from_the_origin(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    places = FAR + np.array([[1.0, 0, 0], [3, 0, 0], [0, 2, 0]])
    inverse = [np.linalg.inv(pose(frame)) for frame in range(3)]
    seen = [places @ T[:3, :3].T + T[:3, 3] for T in inverse]
    poses = (pose(0), pose(1), pose(2), None)
    import_frames(
        (PointFrame(xyz, pose=T) for xyz, T in zip([*seen, places], poses, strict=True)),
        settings.workspace / "sequences" / "survey",
        RecordingInfo("survey", "survey", 1),
    )
    with serving(settings) as served, Client(served.url, TOKEN) as client:
        survey = client["survey"]
        label = survey.create_label("post").id
        (own, *others) = client.call(
            "GET", "/sequences/survey/frames/1/placements", params={"before": 1, "after": 1}
        ).json()
        assert own == {"frame": 1, "T_shown_frame": np.eye(4).ravel().tolist(), "moving": []}
        assert [other["frame"] for other in others] == [0, 2]
        for other in others:
            T = np.reshape(other["T_shown_frame"], (4, 4))
            there = seen[other["frame"]] @ T[:3, :3].T + T[:3, 3]
            np.testing.assert_allclose(there, seen[1], atol=1e-6)
        done = survey.frames[1].stroke(
            label=label, samples=seen[1][:1], radius=0.1, frames=[0, 1, 2]
        )
        assert done.changed == 3
        for frame in range(3):
            assert survey.frames[frame].annotation().tolist() == [label, 0, 0]
        with pytest.raises(BadInputError, match="frame 3 has none"):
            survey.frames[1].stroke(label=label, samples=seen[1][:1], radius=0.1, frames=[3])
        with pytest.raises(NotFoundError):
            survey.frames[1].stroke(label=label, samples=seen[1][:1], radius=0.1, frames=[7])
        assert survey.frames[3].annotation().tolist() == [0, 0, 0]
