"""Recordings shared by the tracking tests, generated once."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import scenes


@pytest.fixture(scope="session")
def tabletop() -> list[scenes.Frame]:
    return scenes.tabletop(seed=2, frames=14)
