"""A run that starts later remembers what the frames before it showed."""

from __future__ import annotations

import numpy as np
import scenes

from pointbrush.tracking import METHODS, FrameKnowledge, FrameResult, Seed, TrackOptions

START = 4


def behind_a_board() -> list[scenes.Frame]:
    """A box in the open, in frame START all but an edge behind a board, then in the open again."""
    rng = np.random.default_rng(4)
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    frames = []
    for number in range(START + 3):
        box = scenes.Part(
            1,
            (40, 90, 200),
            np.array([0, 1.0, 1.6]),
            np.array([0.15, 0.12, 0.1]),
            rot=np.eye(3),
        )
        aside = 0.06 if number == START else 0.6
        board = scenes.Part(
            2,
            (200, 60, 40),
            np.array([aside, 1.0, 1.3]),
            np.array([0.17, 0.15, 0.01]),
            rot=np.eye(3),
        )
        frames.append(camera.shoot([box, board], rng))
    return frames


def run(frames: list[scenes.Frame], before: tuple[int, ...]) -> list[FrameResult]:
    def known(number: int) -> FrameKnowledge | None:
        if number >= START:
            return None
        label = np.where(frames[number].truth == 1, 1, 0).astype(np.uint16)
        return FrameKnowledge(label, 2 * (label > 0).astype(np.uint8), np.zeros(len(label), bool))

    seeds = [Seed(1, np.flatnonzero(frames[START].truth == 1))]
    order = range(START, len(frames))
    options = TrackOptions(before=before)
    return list(METHODS["auto"]().track(frames.__getitem__, order, seeds, known, options))


def overlap(frames: list[scenes.Frame], found: FrameResult) -> float:
    truth = np.flatnonzero(frames[found.frame].truth == 1)
    points = found.assignments.get(1, np.empty(0, np.int64))
    both = len(np.intersect1d(truth, points))
    return both / (len(truth) + len(points) - both)


def test_sides_seen_before_the_start_are_known_after_it() -> None:
    frames = behind_a_board()
    shown = [(frame.truth == 1).sum() for frame in frames]
    assert shown[START] < 0.4 * shown[START + 1]
    results = run(frames, tuple(range(START)))
    assert [found.frame for found in results] == list(range(START, len(frames)))
    assert results[0].tracks[1].state == "painted"
    assert np.allclose(results[0].tracks[1].pose, np.eye(4))
    assert overlap(frames, results[-1]) > 0.9 > overlap(frames, run(frames, ())[-1])
