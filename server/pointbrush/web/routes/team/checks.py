"""Findings about a recording's labels: suspicious things, agreement of annotators, a report.

Two annotators agree on recordings of the same points, labelled twice.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

from fastapi import Query, Response

from pointbrush.values.team.review import Agreement, Checked
from pointbrush.web.context import FramePath, SequenceId, Ws, id_query
from pointbrush.web.security.auth import Caller, TheGate, resource
from pointbrush.web.security.roles import needs, needs_for_file
from pointbrush.work.reviewing.comparing import By
from pointbrush.work.reviewing.report.gather import Table, to_csv
from pointbrush.work.reviewing.report.html import POLICY, to_html

router = resource("review")
PNG = "image/png"
Other = Annotated[str, id_query("the other recording of the same points", "with")]
Frames = Annotated[str | None, Query(pattern=r"^[0-9:]*$", description="I:J")]
CompareBy = Annotated[By, Query(description="match labels by their `name` or by their `category`")]
TEXT = {"schema": {"type": "string"}}


@router.get("/sequences/{seq}/checks", **needs("viewer", 404))
def get_checks(
    seq: SequenceId,
    workspace: Ws,
    frames: Frames = None,
) -> Checked:
    """Find labels with few points or equal names, far from their object, that jump or differ.

    Also boxes that jump, overlap, change their size, float, or lie apart from their points.
    """
    return workspace.reviewing.checks(seq, frames)


@router.get("/sequences/{seq}/agreement", **needs("viewer", 404))
def get_agreement(
    seq: SequenceId,
    workspace: Ws,
    who: Caller,
    gate: TheGate,
    other: Other,
    by: CompareBy = "name",
    frames: Frames = None,
    *,
    boxes: Annotated[bool, Query(description="also compare the boxes of classes")] = False,
) -> Agreement:
    """Return the IoU of each label between two annotations, and the differing points per frame.

    With ``boxes`` also average precision, precision, recall by class, and HOTA.
    """
    gate.require_seen(who, other)
    found = workspace.reviewing.agreement(seq, other, by, frames)
    compared = workspace.reviewing.box_agreement(seq, other, frames) if boxes else None
    return replace(found, boxes=compared)


@router.get(
    "/sequences/{seq}/frames/{i}/agreement", **needs_for_file("viewer", "The frame from above", PNG)
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
    **needs(
        "viewer",
        404,
        answers={
            200: {"description": "The report", "content": {"text/html": TEXT, "text/csv": TEXT}}
        },
    ),
)
def get_report(
    seq: SequenceId,
    workspace: Ws,
    format: Annotated[
        Literal["html", "csv"], Query(description="`html`: a page; `csv`: one table")
    ] = "html",
    table: Annotated[
        Table, Query(description="rows of a CSV: `frames`, `labels` or `people`")
    ] = "frames",
) -> Response:
    """Report progress, points per label, confidence, and time and strokes per frame and person."""
    report = workspace.reviewing.report(seq)
    if format == "html":
        headers = {"Content-Security-Policy": POLICY}
        return Response(to_html(report), media_type="text/html", headers=headers)
    headers = {"Content-Disposition": f'attachment; filename="{seq}-{table}.csv"'}
    return Response(to_csv(report, table), media_type="text/csv", headers=headers)
