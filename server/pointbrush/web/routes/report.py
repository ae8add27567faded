"""A report of a recording's labels, to read or to calculate with."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import Query, Response

from pointbrush.web.auth import resource
from pointbrush.web.context import SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.work.reviewing import POLICY, Table, to_csv, to_html

router = resource("review")
TEXT = {"schema": {"type": "string"}}


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
    """Progress, points per label, confidence, and seconds and strokes per frame and person."""
    report = workspace.reviewing.report(seq)
    if format == "html":
        headers = {"Content-Security-Policy": POLICY}
        return Response(to_html(report), media_type="text/html", headers=headers)
    headers = {"Content-Disposition": f'attachment; filename="{seq}-{table}.csv"'}
    return Response(to_csv(report, table), media_type="text/csv", headers=headers)
