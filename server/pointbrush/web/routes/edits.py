"""Strokes, undo, redo and the history."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

from fastapi import Query
from fastapi.concurrency import run_in_threadpool

from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import FramePath, SequenceId, WholeSequence, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import EditInfoOut, EditOut, StrokeBody, UndoBody

router = resource("edits")


@router.post("/sequences/{seq}/frames/{i}/strokes", responses=responses(404, 409, 413))
async def post_stroke(
    seq: SequenceId, i: FramePath, stroke: StrokeBody, workspace: Ws, who: Caller
) -> EditOut:
    """Apply a stroke; the call returns when the edit is durable.

    Deleted points and points of locked and hidden labels (``visible: false``, or in the stroke's
    ``hidden``) do not change; painting with such a label is refused (409).
    """
    # Async, because FastAPI validates the answer of other functions in another thread call.
    apply = workspace.strokes.apply
    return EditOut.of(await run_in_threadpool(apply, seq, i, stroke.model_dump(), who.author))


@router.post("/sequences/{seq}/undo", responses=responses(404, 409, 413))
def undo(seq: WholeSequence, workspace: Ws, who: Caller, body: UndoBody | None = None) -> EditOut:
    """Take back the caller's last edit, or ``edit``, except on points with a later edit."""
    given = body or UndoBody()
    return EditOut.of(workspace.labels.undo(seq, who.author, given.id, given.edit))


@router.post("/sequences/{seq}/redo", responses=responses(404, 409, 413))
def redo(seq: WholeSequence, workspace: Ws, who: Caller, body: UndoBody | None = None) -> EditOut:
    """Restore the edit that the caller's last undo took back, or ``edit``."""
    given = body or UndoBody()
    return EditOut.of(workspace.labels.redo(seq, who.author, given.id, given.edit))


@router.get("/sequences/{seq}/edits", responses=responses(404))
def list_edits(
    seq: WholeSequence,
    workspace: Ws,
    before: Annotated[int | None, Query(ge=0, lt=2**53, description="a revision")] = None,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
) -> list[EditInfoOut]:
    """Return the edits, the newest first."""
    name = workspace.labels.accounts.name
    edits = workspace.labels.edits(seq, before=before, limit=limit)
    return [EditInfoOut.of(replace(edit, author=name(edit.author))) for edit in edits]
