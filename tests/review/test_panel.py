"""The review panel: colours, doubts, and the page itself."""

from __future__ import annotations

import urllib.request
from contextlib import closing
from pathlib import Path

import numpy as np
from serving import add_sequence, settings_in

from pointbrush.labels import Label
from pointbrush.review.drawing import blend, lookup
from pointbrush.review.panel import ReviewPanel, doubtful_frames
from pointbrush.workspace import Workspace
from tests.ports import free_port
from tests.waiting import PATIENCE

REST = {"pose": np.eye(4).ravel().tolist(), "rmse": 0.0, "inliers": 1.0, "points": 0}


def test_doubts_are_lost_occluded_or_unsure_frames() -> None:
    tracks = [
        {"frame": 3, "state": "tracked", "confidence": 0.9},
        {"frame": 2, "state": "tracked", "confidence": 0.4},
        {"frame": 7, "state": "lost", "confidence": 0.9},
        {"frame": 5, "state": "occluded", "confidence": 0.6},
        {"frame": 5, "state": "painted", "confidence": 1.0},
    ]
    assert doubtful_frames(tracks) == [2, 5, 7]


def test_labels_colour_only_labelled_points() -> None:
    rgb = np.array([[10, 20, 30], [10, 20, 30]], np.uint8)
    colors = lookup([Label(4, "pin", color="#ff0000")])
    mixed = blend(rgb, np.array([0, 4], np.uint16), colors, 0.5)
    assert mixed[0].tolist() == [10, 20, 30]
    assert mixed[1].tolist() == [132, 10, 15]
    assert blend(None, np.array([4], np.uint16), colors, 1.0).tolist() == [[255, 0, 0]]


def test_the_page_is_served_and_jumps_between_doubts(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "walls", frames=6, points=2000)
    with closing(Workspace(settings)) as workspace:
        workspace.labels.create_label("walls", "ada", name="wall")
        tracks = [
            {"frame": frame, "label": 1, "state": state, "confidence": 0.9, **REST}
            for frame, state in ((1, "tracked"), (2, "lost"), (4, "lost"))
        ]
        workspace.labels.apply(
            "walls",
            edit_id=None,
            author="ada",
            kind="tracking",
            writes={},
            summary="",
            tracks=tracks,
        )
        with closing(ReviewPanel(workspace, "walls", port=free_port())) as panel:
            page = urllib.request.urlopen(
                f"http://127.0.0.1:{panel.port}/", timeout=PATIENCE
            ).read()
            assert b"<html" in page
            frames = []
            for direction in (1, 1, 1, -1, -1):
                panel.jump(direction)
                frames.append(panel.frame)
            assert frames == [2, 4, 4, 2, 2]
