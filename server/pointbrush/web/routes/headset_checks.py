"""Checks of headsets: a recording to try the controls in, and the reports."""

from __future__ import annotations

from datetime import datetime

from pydantic import BaseModel, Field, model_validator

from pointbrush.headset_report.model import HeadsetReport
from pointbrush.values.base import integral
from pointbrush.values.headset_checks import HeadsetCheck, NewHeadsetReport
from pointbrush.web.context import Ws
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs

router = resource("headset checks")


class HeadsetReportBody(HeadsetReport):
    """The report of a headset check, as the page makes it."""

    _integral = model_validator(mode="before")(integral)


class KeptHeadsetReport(BaseModel):
    """A report, the account that sent it, and the time at which it arrived."""

    id: str = Field(description="Id of the report.")
    account: str = Field(description="Account that sent it.")
    received: datetime = Field(description="Time at which it arrived.")
    report: HeadsetReport = Field(description="The report, as the page made it.")


@router.post("/headset-checks", **needs("annotator", 409))
def begin_headset_check(workspace: Ws) -> HeadsetCheck:
    """Return the scratch recording for a headset check, without labelled points.

    The first call of a workspace makes the recording, which takes some seconds.
    """
    return HeadsetCheck(workspace.scratch.prepare())


@router.post("/headset-reports", status_code=201, **needs("annotator", 413))
def add_headset_report(body: HeadsetReportBody, workspace: Ws, who: Caller) -> NewHeadsetReport:
    """Store the report of a headset check; a workspace keeps the newest 50."""
    kept = workspace.labels.headset_reports
    return NewHeadsetReport(kept.add(who.author, body.model_dump()))


@router.get("/headset-reports", **needs("manager"))
def list_headset_reports(workspace: Ws) -> list[KeptHeadsetReport]:
    """List the reports of headset checks, newest first."""
    return [
        KeptHeadsetReport.model_validate(each, from_attributes=True)
        for each in workspace.labels.headset_reports.all()
    ]
