"""States, notes and assignments of frames and labels."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query

from pointbrush.accounts.roles import includes, require
from pointbrush.teamwork.reviews import Review
from pointbrush.values.kinds import time_of
from pointbrush.values.team.review import (
    Decision,
    FrameReviewPatch,
    ReviewOverview,
    ReviewPatch,
    Standing,
)
from pointbrush.web.context import FramePath, SequenceId, Ws
from pointbrush.web.security.auth import Caller, Principal, resource
from pointbrush.web.security.roles import ASSIGN, DECIDE, needs
from pointbrush.workspace import Workspace

router = resource("review")
DECISIONS = frozenset({"accepted", "rejected"})


@router.get("/sequences/{seq}/review", **needs("viewer", 404))
def get_review(seq: SequenceId, workspace: Ws) -> ReviewOverview:
    """Return the state of each frame and label."""
    return workspace.reviewing.overview(seq)


@router.put("/sequences/{seq}/review", **needs("annotator", 404, 413))
def put_review(seq: SequenceId, body: ReviewPatch, workspace: Ws, who: Caller) -> ReviewOverview:
    """Set state, note or assignee of frames ``first`` to ``last``, or state and note of a label.

    Accepting, rejecting and reverting these need the role reviewer; assigning frames to people
    needs the role manager.  A frame or label that is accepted or reopened loses its note.
    """
    _put(workspace, seq, who, body, body.first, body.last)
    return workspace.reviewing.overview(seq)


@router.get("/sequences/{seq}/review/history", **needs("viewer", 404))
def get_history(
    seq: SequenceId,
    workspace: Ws,
    limit: Annotated[int, Query(ge=1, le=1000, description="most lines")] = 100,
) -> list[Decision]:
    """Return the decisions and their authors, the newest first."""
    return [_decision(each) for each in workspace.reviewing.history(seq)[:limit]]


@router.get("/sequences/{seq}/frames/{i}/review", **needs("viewer", 404))
def get_frame_review(
    seq: SequenceId,
    i: FramePath,
    workspace: Ws,
    label: Annotated[int | None, Query(ge=1, le=65534, description="in this frame")] = None,
) -> Standing:
    """Return the state of a frame, or of a label in it."""
    return workspace.reviewing.frame(seq, i, label or 0)


@router.put("/sequences/{seq}/frames/{i}/review", **needs("annotator", 404, 413))
def put_frame_review(
    seq: SequenceId, i: FramePath, body: FrameReviewPatch, workspace: Ws, who: Caller
) -> Standing:
    """Set state, note or assignee of a frame, or state and note of a label in it."""
    _put(workspace, seq, who, body, i, i)
    return workspace.reviewing.frame(seq, i, body.label or 0)


def _put(
    workspace: Workspace,
    seq: str,
    who: Principal,
    body: FrameReviewPatch,
    first: int | None,
    last: int | None,
) -> None:
    if body.state in DECISIONS:
        require(who.role, DECIDE)
    if body.assignee is not None:
        require(who.role, ASSIGN)
    review = Review(first, last, body.label or 0, body.state, body.note, body.place, body.assignee)
    workspace.reviewing.put(seq, who.author, review, decides=includes(who.role, DECIDE))


def _decision(found: Review) -> Decision:
    return Decision.of(found, label=found.label or None, by=found.author, at=time_of(found.time))
