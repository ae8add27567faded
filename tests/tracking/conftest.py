"""Recordings shared by the tracking tests, generated once."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

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


@pytest.fixture(scope="session")
def tabletop() -> list[scenes.Frame]:
    return scenes.tabletop(seed=2, frames=14)


@pytest.fixture(scope="session")
def passing() -> list[scenes.Frame]:
    return scenes.passing()


@pytest.fixture(scope="session")
def followed(passing: list[scenes.Frame]) -> list[FrameResult]:
    """What `auto` finds of two people, one of whom hides the other for a while."""
    return follow(passing)
