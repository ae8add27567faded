"""Reports of headset checks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from pointbrush.client.steps import L, Part, Steps, steps


@dataclass(frozen=True, slots=True)
class HeadsetReport:
    """A report, the account that sent it, and the time at which it arrived."""

    id: str
    account: str
    received: datetime
    report: dict[str, Any]


class HeadsetReports(Part[L]):
    """The reports of headset checks of a workspace, which keeps the newest 50."""

    @steps
    def all(self) -> Steps[list[HeadsetReport]]:
        """Return the reports, newest first, for managers."""
        return self._get(list[HeadsetReport], "/headset-reports")

    @steps
    def add(self, report: Mapping[str, Any]) -> Steps[str]:
        """Store a report as ``/check-headset`` writes it, and return its id."""
        answer = yield from self._call("POST", "/headset-reports", json=dict(report))
        return str(answer.json()["id"])
