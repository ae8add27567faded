"""Checks of headsets: a recording to try the controls in, and the reports."""

from __future__ import annotations

from datetime import datetime

from pydantic import BaseModel, model_validator

from pointbrush.headset_report.model import HeadsetReport
from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import Out, integral

router = resource("headset checks")


class CheckOut(BaseModel):
    """A check that can begin in the recording ``sequence``, which no list contains."""

    sequence: str


class HeadsetReportBody(HeadsetReport):
    """The report of a headset check, as the page makes it."""

    _integral = model_validator(mode="before")(integral)


class NewHeadsetReportOut(BaseModel):
    """The stored report's id."""

    id: str


class HeadsetReportOut(Out):
    """A report, the account that sent it, and the time at which it arrived."""

    id: str
    account: str
    received: datetime
    report: HeadsetReport


@router.post("/headset-checks", responses=responses(409))
def begin_headset_check(workspace: Ws) -> CheckOut:
    """Return the scratch recording for a headset check, without labelled points.

    The first call of a workspace makes the recording, which takes some seconds.
    """
    return CheckOut(sequence=workspace.scratch.prepare())


@router.post("/headset-reports", status_code=201, responses=responses(413))
def add_headset_report(body: HeadsetReportBody, workspace: Ws, who: Caller) -> NewHeadsetReportOut:
    """Store the report of a headset check; a workspace keeps the newest 50."""
    kept = workspace.labels.headset_reports
    return NewHeadsetReportOut(id=kept.add(who.author, body.model_dump()))


@router.get("/headset-reports", responses=responses())
def list_headset_reports(workspace: Ws) -> list[HeadsetReportOut]:
    """List the reports of headset checks, newest first."""
    return [HeadsetReportOut.of(each) for each in workspace.labels.headset_reports.all()]
