"""A tracking run's outcome in words."""

from __future__ import annotations

import numpy as np

from pointbrush.tracking import FrameResult, TrackState
from pointbrush.work.tracking.runs import run_summary


def state(points: int, confidence: float, said: str = "tracked") -> TrackState:
    return TrackState(np.eye(4), 0.0, 1.0, confidence, points, said)  # type: ignore[arg-type]


def test_each_label_is_told_with_its_frames_and_doubts() -> None:
    names = {1: "pin 1", 2: "hand"}
    results = [
        FrameResult(3, {}, {1: state(9, 1.0, "painted")}),
        FrameResult(4, {}, {1: state(9, 0.9), 2: state(5, 0.2)}),
        FrameResult(5, {}, {1: state(0, 0.0, "lost"), 2: state(0, 0.8, "occluded")}),
        FrameResult(6, {}, {1: state(9, 0.3)}),
    ]
    assert (
        run_summary(results, 3, names) == "pin 1: 2 frames, 2 doubtful; hand: 1 frame, 1 doubtful"
    )


def test_many_labels_are_summed_up() -> None:
    one = FrameResult(1, {}, {number: state(9, 0.1) for number in range(1, 8)})
    told = run_summary([one], 0, {})
    assert told.endswith("; 4: 1 frame, 1 doubtful; 3 more labels, 3 frames doubtful")
