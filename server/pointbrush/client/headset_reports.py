"""Reports of headset checks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from pointbrush.client.answers import read
from pointbrush.client.steps import L, Part, Request, Steps, send, steps


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
        answer = yield from send(Request("GET", "/headset-reports", idempotent=True))
        return [read(HeadsetReport, entry) for entry in answer.json()]

    @steps
    def add(self, report: Mapping[str, Any]) -> Steps[str]:
        """Store a report as ``/check-headset`` writes it, and return its id."""
        request = Request("POST", "/headset-reports", {"json": dict(report)})
        return str((yield from send(request)).json()["id"])
