"""Small recordings that need a rule of the tracker: without it their labels get worse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import scenes
from guards import recordings

from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.interface import Method
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.registry import with_options

LEAST = 40
"""Points in the truth from which an object counts as visible."""
NEVER = 1e9
"""More than any share or ratio that occurs."""


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
    ("rule", "without", "recording", "loss"),
    [
        (
            "points hardly before the scene",
            {"background": {"faint_sigmas": 3.0}},
            recordings.pushed_aside,
            0.05,
        ),
        ("whole frame searched", {"relocate": {"doubt": NEVER}}, recordings.pushed_aside, 0.05),
        ("motion", {"search": {"remembered_poses": 1}}, recordings.pushed_aside, 0.03),
        ("surface beside", {"register": {"excess_cost": 0.0}}, recordings.thrown, 0.1),
        ("people together", {"body": {"limb_m": 0.0}}, scenes.passing, 0.02),
    ],
)
def test_labels_get_worse_without_a_rule(
    rule: str,
    without: dict[str, dict[str, Any]],
    recording: Callable[[], list[scenes.Frame]],
    loss: float,
) -> None:
    frames, whole = shot(recording)
    options = TrackerOptions()
    changed = {group: replace(getattr(options, group), **v) for group, v in without.items()}
    method = with_options(replace(options, **changed))
    assert overlap(frames, method) < whole - loss, rule
