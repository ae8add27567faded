"""A short form of `make torture`: a round of the first scenario of each module, and of others."""

from __future__ import annotations

import pytest

from tests.torture import scenarios
from tests.torture.framework import SCENARIOS, run

scenarios.load()
SECONDS = 1.0
LEFT = ("dask-lost", "too-little-memory")
"""Long ones, whose faults tests/test_jobs_again.py and tests/web/test_shortages.py have, too."""
MORE = ("two-projects",)
"""Further ones; the others have short forms in tests/web/test_oidc.py and tests/formats."""
FIRST = {
    each.run.__module__: name for name, each in reversed(SCENARIOS.items()) if name not in LEFT
}
"""Names of scenarios by module."""


@pytest.mark.timeout(300)
@pytest.mark.parametrize("name", sorted({*FIRST.values(), *MORE}))
def test_nothing_is_lost(name: str) -> None:
    row = run(SCENARIOS[name], SECONDS, seed=1)
    if row.skipped:
        pytest.skip(row.skipped)
    assert row.tally.sound, "\n".join(row.tally.notes)
