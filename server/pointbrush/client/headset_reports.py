"""Reports of headset checks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pointbrush.client.steps import L, Part, Steps, steps
from pointbrush.values.headset_checks import HeadsetReport, HeadsetReportFile, NewHeadsetReport


class HeadsetReports(Part[L]):
    """The reports of headset checks of a workspace, which keeps the newest 50."""

    @steps
    def all(self) -> Steps[list[HeadsetReport]]:
        """Return the reports, newest first, for managers."""
        return self._get(list[HeadsetReport], "/headset-reports")

    @steps
    def add(self, report: HeadsetReportFile | Mapping[str, Any]) -> Steps[str]:
        """Store a report as ``/check-headset`` writes it, and return its id."""
        path = "/headset-reports"
        made = yield from self._change(NewHeadsetReport, "POST", path, report, idempotent=False)
        return made.id
