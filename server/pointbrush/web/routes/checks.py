"""Suspicious things in the labels of a recording."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query
from pydantic import BaseModel, Field

from pointbrush.streaming.messages import Vec3
from pointbrush.web.auth import resource
from pointbrush.web.context import SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.work.reviewing import Checked, Finding, Kind

router = resource("review")


class FindingOut(BaseModel):
    """A suspicious thing; its ``id`` is the same at every check as long as it is there."""

    id: str
    kind: Kind
    text: str
    labels: list[int]
    first: int | None
    last: int | None
    place: Annotated[Vec3 | None, Field(description="in frame `first`, source coordinates")]
    settled: Annotated[bool, Field(description="its frames or labels are accepted as they are")]

    @classmethod
    def of(cls, finding: Finding) -> FindingOut:
        """From the workspace's."""
        return cls(
            id=finding.id, kind=finding.kind, text=finding.text, labels=list(finding.labels),
            first=finding.first, last=finding.last,
            place=None if finding.place is None else list(finding.place),
            settled=finding.settled,
        )  # fmt: skip


class ChecksOut(BaseModel):
    """Findings in the order to go through them, and what could not be looked at."""

    findings: list[FindingOut]
    unchecked: list[str]

    @classmethod
    def of(cls, checked: Checked) -> ChecksOut:
        """From the workspace's."""
        findings = [FindingOut.of(each) for each in checked.findings]
        return cls(findings=findings, unchecked=list(checked.unchecked))


@router.get("/sequences/{seq}/checks", responses=responses(404))
def get_checks(
    seq: SequenceId,
    workspace: Ws,
    frames: Annotated[str | None, Query(pattern=r"^[0-9:]*$", description="I:J")] = None,
) -> ChecksOut:
    """Labels of few points, of one name, far from their object, that jump, unlike neighbours."""
    return ChecksOut.of(workspace.reviewing.checks(seq, frames))
