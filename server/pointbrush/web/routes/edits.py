"""Strokes, undo, redo and the history."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from fastapi import Query
from fastapi.concurrency import run_in_threadpool

from pointbrush.labels import EditInfo
from pointbrush.values.edits import Edit, PastEdit, Undo
from pointbrush.web.context import FramePath, SequenceId, WholeSequence, Ws
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs
from pointbrush.web.strokes import StrokeBody
from pointbrush.workspace import Workspace

router = resource("edits")


@router.post("/sequences/{seq}/frames/{i}/strokes", **needs("annotator", 404, 409, 413))
async def post_stroke(
    seq: SequenceId, i: FramePath, stroke: StrokeBody, workspace: Ws, who: Caller
) -> Edit:
    """Apply a stroke; the call returns when the edit is durable.

    Deleted points and points of locked and hidden labels (``visible: false``, or in the stroke's
    ``hidden``) do not change; painting with such a label is refused (409).
    """
    # Async, because FastAPI validates the answer of other functions in another thread call.
    apply = workspace.strokes.apply
    return await run_in_threadpool(apply, seq, i, stroke.model_dump(), who.author)


@router.post("/sequences/{seq}/undo", **needs("annotator", 404, 409, 413))
def undo(seq: WholeSequence, workspace: Ws, who: Caller, body: Undo | None = None) -> Edit:
    """Take back the caller's last edit, or ``edit``, except on points with a later edit."""
    given = body or Undo()
    return workspace.labels.undo(seq, who.author, given.id, given.edit)


@router.post("/sequences/{seq}/redo", **needs("annotator", 404, 409, 413))
def redo(seq: WholeSequence, workspace: Ws, who: Caller, body: Undo | None = None) -> Edit:
    """Restore the edit that the caller's last undo took back, or ``edit``."""
    given = body or Undo()
    return workspace.labels.redo(seq, who.author, given.id, given.edit)


@router.get("/sequences/{seq}/edits", **needs("viewer", 404))
def list_edits(
    seq: WholeSequence,
    workspace: Ws,
    before: Annotated[int | None, Query(ge=0, lt=2**53, description="a revision")] = None,
    limit: Annotated[int, Query(ge=1, le=1000, description="most edits to return")] = 100,
) -> list[PastEdit]:
    """Return the edits, the newest first."""
    edits = workspace.labels.edits(seq, before=before, limit=limit)
    return [past_edit(edit, workspace) for edit in edits]


def past_edit(edit: EditInfo, workspace: Workspace) -> PastEdit:
    """Return an edit with the name of its author."""
    return replace(edit, author=workspace.labels.accounts.name(edit.author))
