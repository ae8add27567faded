"""Fixtures that every part's tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

SHARED = Path(__file__).parent.parent.parent / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of real recordings beside the checkout."""
    if not (SHARED / "realdata").is_dir():
        pytest.skip("the real recordings (../shared) are not on this machine")
    return SHARED
