"""Fixtures that every part's tests share."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# A busy machine must fail no test: how long something takes is the benchmarks' concern.
settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any machine")

SHARED = Path(__file__).parent.parent.parent / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of real recordings beside the checkout."""
    if not (SHARED / "realdata").is_dir():
        pytest.skip("the real recordings (../shared) are not on this machine")
    return SHARED
