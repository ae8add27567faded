"""The server is killed at random moments while people edit: what was answered stays."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.faults.torture import torture

KILLS = int(os.environ.get("POINTBRUSH_KILLS", "5"))


@pytest.mark.timeout(120 + 20 * KILLS)
def test_nothing_answered_is_lost_and_nothing_is_half_applied(tmp_path: Path) -> None:
    summary = torture(tmp_path / "workspace", KILLS, seed=int(os.environ.get("SEED", "1")))
    assert summary.kills == KILLS
    assert summary.edits > KILLS
