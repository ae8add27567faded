"""Findings about a recording's labels: suspicious things, agreement of annotators, a report.

Two annotators agree on recordings of the same points, labelled twice.
"""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import Query, Response
from pydantic import Field

from pointbrush.streaming.messages import Vec3
from pointbrush.web.auth import Caller, TheGate, resource
from pointbrush.web.context import FramePath, SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import Out
from pointbrush.work.reviewing import (
    POLICY,
    By,
    Kind,
    Table,
    to_csv,
    to_html,
)

router = resource("review")
PNG = "image/png"
Other = Annotated[
    str,
    Query(
        alias="with",
        pattern=r"^[a-z0-9][a-z0-9._-]{0,63}$",
        max_length=64,
        description="the other recording of the same points",
    ),
]
Share = Annotated[float, Field(ge=0, le=1)]
CompareBy = Annotated[By, Query(description="compare labels by")]
TEXT = {"schema": {"type": "string"}}


class FindingOut(Out):
    """A finding; its ``id`` is the same in every check until the finding is gone."""

    id: str
    kind: Kind
    text: str
    labels: list[int]
    first: int | None
    last: int | None
    place: Annotated[Vec3 | None, Field(description="in frame `first`, source coordinates")]
    settled: Annotated[bool, Field(description="its frames or labels are accepted")]


class ChecksOut(Out):
    """Findings in order of importance, and the parts that could not be checked."""

    findings: list[FindingOut]
    unchecked: list[str]


@router.get("/sequences/{seq}/checks", responses=responses(404))
def get_checks(
    seq: SequenceId,
    workspace: Ws,
    frames: Annotated[str | None, Query(pattern=r"^[0-9:]*$", description="I:J")] = None,
) -> ChecksOut:
    """Find labels with few points or equal names, far from their object, that jump or differ.

    Also boxes that jump, overlap, change their size, float, or lie apart from their points.
    """
    return ChecksOut.of(workspace.reviewing.checks(seq, frames))


class LabelAgreementOut(Out):
    """A label by name: its points in the first annotation, the second and both."""

    name: str
    iou: Share
    first: int
    second: int
    both: int


class FrameAgreementOut(Out):
    """Number of labelled points of a frame in either annotation, and of differing points."""

    frame: int
    labelled: int
    differ: int


class BoxScoreOut(Out):
    """Boxes of the second annotation compared with the first; boxes match from a 3D IoU on."""

    iou: Share
    ap: Share
    precision: Share
    recall: Share


class ClassAgreementOut(Out):
    """Boxes of a class, counted in each frame."""

    name: str
    first: int
    second: int
    mean_iou: Share | None
    scores: list[BoxScoreOut]


class BoxAgreementOut(Out):
    """Agreement of boxes; ``hota`` is null without boxes or without the package trackeval."""

    classes: list[ClassAgreementOut]
    hota: Share | None


class AgreementOut(Out):
    """Null if neither annotation has labels; ``boxes`` only on request."""

    miou: Share | None
    same: Share | None
    labels: list[LabelAgreementOut]
    frames: list[FrameAgreementOut]
    boxes: BoxAgreementOut | None = None


@router.get("/sequences/{seq}/agreement", responses=responses(404))
def get_agreement(
    seq: SequenceId,
    workspace: Ws,
    who: Caller,
    gate: TheGate,
    other: Other,
    by: CompareBy = "name",
    frames: Annotated[str | None, Query(pattern=r"^[0-9:]*$", description="I:J")] = None,
    *,
    boxes: Annotated[bool, Query(description="also compare the boxes of classes")] = False,
) -> AgreementOut:
    """Return the IoU of each label between two annotations, and the differing points per frame.

    With ``boxes`` also average precision, precision, recall by class, and HOTA.
    """
    gate.require_seen(who, other)
    found = AgreementOut.of(workspace.reviewing.agreement(seq, other, by, frames))
    if boxes:
        compared = workspace.reviewing.box_agreement(seq, other, frames)
        found.boxes = BoxAgreementOut.of(compared)
    return found


@router.get(
    "/sequences/{seq}/frames/{i}/agreement",
    response_class=Response,
    responses={
        200: {
            "description": "The frame from above",
            "content": {PNG: {"schema": {"type": "string", "format": "binary"}}},
        },
        **responses(404),
    },
)
def get_difference(
    seq: SequenceId,
    i: FramePath,
    workspace: Ws,
    who: Caller,
    gate: TheGate,
    other: Other,
    by: CompareBy = "name",
) -> Response:
    """Draw the differences of two annotations as a picture from above.

    Blue: labelled only in the first; orange: only in the second; pink: different; light: equal.
    """
    gate.require_seen(who, other)
    return Response(workspace.reviewing.difference(seq, other, i, by), media_type=PNG)


@router.get(
    "/sequences/{seq}/report",
    response_class=Response,
    responses={
        200: {"description": "The report", "content": {"text/html": TEXT, "text/csv": TEXT}},
        **responses(404),
    },
)
def get_report(
    seq: SequenceId,
    workspace: Ws,
    format: Annotated[Literal["html", "csv"], Query()] = "html",
    table: Annotated[Table, Query(description="of a CSV")] = "frames",
) -> Response:
    """Report progress, points per label, confidence, and time and strokes per frame and person."""
    report = workspace.reviewing.report(seq)
    if format == "html":
        headers = {"Content-Security-Policy": POLICY}
        return Response(to_html(report), media_type="text/html", headers=headers)
    headers = {"Content-Disposition": f'attachment; filename="{seq}-{table}.csv"'}
    return Response(to_csv(report, table), media_type="text/csv", headers=headers)
