"""Exports, streamed while they are written."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query, Request, Response

from pointbrush.formats import EXPORTS
from pointbrush.web.auth import Caller, Principal, resource
from pointbrush.web.context import SequenceId, Ws, one_of
from pointbrush.web.exports import respond
from pointbrush.web.problems import responses

router = resource("export")
BINARY = {"schema": {"type": "string", "format": "binary"}}
FrameRange = Annotated[
    str | None, Query(pattern=r"^[0-9]{0,9}(:[0-9]{0,9})?$", description="I:J, J not included")
]


@router.get(
    "/sequences/{seq}/export",
    response_class=Response,
    responses={
        200: {"description": "The export", "content": {"application/zip": BINARY}},
        **responses(404),
    },
)
async def export_sequence(
    seq: SequenceId,
    workspace: Ws,
    request: Request,
    who: Caller,
    format: Annotated[str, Query(pattern=one_of(EXPORTS))],
    frames: FrameRange = None,
) -> Response:
    """Frames with their labels in the source's order, as a zip."""
    return await respond(
        request.app.state.exports,
        person_of(request, who),
        lambda file: workspace.export(seq, format, file, frames),
        {"Content-Disposition": f'attachment; filename="{seq}-{format}.zip"'},
    )


def person_of(request: Request, who: Principal) -> str:
    """Return what tells people apart; several who share the server's own token by address."""
    address = request.client.host if who.shared and request.client else ""
    return f"{who.author} {address}"
