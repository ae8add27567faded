"""Small recordings that need a rule of the tracker: without it their labels get worse.

``benchmarks/tracking_ablation.py`` names the rules, and how each is taken out.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import scenes
from guards import recordings

from benchmarks.tracking_ablation import without
from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.interface import Method
from pointbrush.tracking.registry import with_options

LEAST = 40
"""Points in the truth from which an object counts as visible."""


def overlap(frames: list[scenes.Frame], method: Method) -> float:
    """Mean IoU of all labels of the first frame in the frames that follow and show them."""
    first = frames[0].truth
    seeds = [Seed(n, np.flatnonzero(first == n)) for n in np.unique(first).tolist() if n]
    order, found = range(len(frames)), []
    asked = TrackOptions(continue_lost=True)
    for result in method.track(frames.__getitem__, order, seeds, lambda _: None, asked):
        for seed in seeds:
            truth = frames[result.frame].truth == seed.label
            points = result.assignments.get(seed.label, np.empty(0, np.int64))
            if result.frame and truth.sum() >= LEAST:
                both = truth[points].sum()
                found.append(both / (truth.sum() + len(points) - both))
    return float(np.mean(found))


@cache
def shot(recording: Callable[[], list[scenes.Frame]]) -> tuple[list[scenes.Frame], float]:
    """The frames of a recording, and the overlap with all rules."""
    frames = recording()
    return frames, overlap(frames, METHODS["auto"]())


@pytest.mark.parametrize(
    ("idea", "recording", "loss"),
    [
        ("hardly before the scene", recordings.pushed_aside, 0.05),
        ("whole frame searched", recordings.pushed_aside, 0.05),
        ("motion", recordings.pushed_aside, 0.03),
        ("surface beside", recordings.thrown, 0.1),
        ("people together", scenes.passing, 0.02),
    ],
)
def test_labels_get_worse_without_a_rule(
    idea: str, recording: Callable[[], list[scenes.Frame]], loss: float
) -> None:
    frames, whole = shot(recording)
    assert overlap(frames, with_options(without(idea))) < whole - loss
