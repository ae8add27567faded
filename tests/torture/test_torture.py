"""A short form of `make torture`: a round of the first scenario of most modules, at a slow pace."""

from __future__ import annotations

import pytest

from tests.torture import authors, scenarios
from tests.torture.framework import SCENARIOS, run

scenarios.load()
SECONDS = 1.0
LEFT = {
    "changed_objects": "work/test_sequence_store.py",
    "clocks": "work/test_deletion.py, web/test_auth.py",
    "clusters": "test_jobs_again.py, faults/test_proxy.py",
    "crowds": "faults/test_descriptors.py, web/test_hostile.py",
    "damage": "faults/test_damage.py",
    "disks": "faults/test_full_disk.py, faults/test_descriptors.py, database/test_durability.py",
    "encrypted": "web/test_tls_round.py, web/test_log_limits.py",
    "many_imports": "test_jobs_again.py, faults/test_scripts_survive.py",
    "old_workspaces": "database/test_old_workspace.py, faults/test_jobs_survive.py",
    "outgoing": "test_outgoing.py, web/test_webhooks.py, web/test_oidc.py",
}
"""Modules of scenarios, and the tests that have their faults, too."""
MORE = ("two-projects",)
FIRST = {each.run.__module__.rpartition(".")[2]: name for name, each in reversed(SCENARIOS.items())}
"""Names of scenarios by module."""
SHORT = sorted({*MORE, *(name for module, name in FIRST.items() if module not in LEFT)})


@pytest.mark.timeout(300)
@pytest.mark.parametrize("name", SHORT)
def test_nothing_is_lost(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(authors, "EDIT_PAUSE", 0.1)
    row = run(SCENARIOS[name], SECONDS, seed=1)
    if row.skipped:
        pytest.skip(row.skipped)
    assert row.tally.sound, "\n".join(row.tally.notes)
