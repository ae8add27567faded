"""Recordings shared by the tracking tests, generated once."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import scenes
from runs import follow

from pointbrush.tracking import FrameResult


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
