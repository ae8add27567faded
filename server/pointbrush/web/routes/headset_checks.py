"""Checks of headsets: a recording to try the controls in, and the reports."""

from __future__ import annotations

from pointbrush.values.headset_checks import (
    HeadsetCheck,
    HeadsetReport,
    HeadsetReportFile,
    NewHeadsetReport,
)
from pointbrush.web.context import Ws
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs

router = resource("headset checks")


@router.post("/headset-checks", **needs("annotator", 409))
def begin_headset_check(workspace: Ws) -> HeadsetCheck:
    """Return the scratch recording for a headset check, without labelled points.

    The first call of a workspace makes the recording, which takes some seconds.
    """
    return HeadsetCheck(workspace.scratch.prepare())


@router.post("/headset-reports", status_code=201, **needs("annotator", 413))
def add_headset_report(body: HeadsetReportFile, workspace: Ws, who: Caller) -> NewHeadsetReport:
    """Store the report of a headset check; a workspace keeps the newest 50."""
    return NewHeadsetReport(workspace.labels.headset_reports.add(who.author, body))


@router.get("/headset-reports", **needs("manager"))
def list_headset_reports(workspace: Ws) -> list[HeadsetReport]:
    """List the reports of headset checks, newest first."""
    return workspace.labels.headset_reports.all()
