"""A short form of each scenario of `make torture`: a round or two."""

from __future__ import annotations

import pytest

from tests.torture import scenarios
from tests.torture.framework import SCENARIOS, run

scenarios.load()
SECONDS = 1.0


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize("name", SCENARIOS)
def test_nothing_is_lost(name: str) -> None:
    row = run(SCENARIOS[name], SECONDS, seed=1)
    if row.skipped:
        pytest.skip(row.skipped)
    assert row.tally.sound, "\n".join(row.tally.notes)
