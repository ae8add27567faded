"""Whole runs over the recordings of the tests."""

from __future__ import annotations

import numpy as np
import scenes

from pointbrush.tracking import METHODS, FrameResult, Seed, TrackOptions


def follow(frames: list[scenes.Frame], method: str = "auto") -> list[FrameResult]:
    """A run of every label of the first frame's truth; nothing else is known."""
    truth = frames[0].truth
    assert truth is not None
    seeds = [Seed(n, np.flatnonzero(truth == n)) for n in np.unique(truth).tolist() if n]
    order = range(len(frames))
    run = METHODS[method]().track(frames.__getitem__, order, seeds, lambda _: None, TrackOptions())
    return list(run)
