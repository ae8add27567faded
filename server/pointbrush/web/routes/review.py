"""States, notes and assignments of frames and labels."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated

from fastapi import Query
from pydantic import BeforeValidator, Field

from pointbrush.accounts.roles import includes, require
from pointbrush.streaming.messages import FrameIndex, Vec3
from pointbrush.teamwork.reviews import Review
from pointbrush.web.auth import Caller, Principal, resource
from pointbrush.web.context import FramePath, SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.roles import ASSIGN, DECIDE
from pointbrush.web.schemas import VISIBLE, Body, Out, PaintId
from pointbrush.work.reviewing import State
from pointbrush.workspace import Workspace

router = resource("review")
DECISIONS = frozenset({"accepted", "rejected"})
Note = Annotated[str, Field(max_length=2_000, pattern=r"^[^\x00-\x08\x0b-\x1f\x7f]*$")]
Person = Annotated[str, Field(max_length=128, pattern=f"^{VISIBLE}*$")]


class FrameReviewBody(Body):
    """Values to set; missing fields do not change, "" removes a note or an assignee."""

    state: State | None = None
    note: Note | None = None
    place: Annotated[Vec3, Field(description="where the note is pinned, source")] | None = None
    assignee: Person | None = None
    label: PaintId | None = None


class ReviewBody(FrameReviewBody):
    """Values for frames ``first`` to ``last``, or for a label in all frames."""

    first: FrameIndex | None = None
    last: FrameIndex | None = None


LabelOrNone = Annotated[
    int | None,
    BeforeValidator(lambda label: label or None),
    Field(description="null: the frames themselves"),
]


class StandingOut(Out):
    """State of frames ``first`` to ``last``, or of a label in all frames."""

    first: int | None
    last: int | None
    label: LabelOrNone
    state: State
    note: str
    place: Vec3 | None
    assignee: str
    by: str
    at: datetime | None
    changed: Annotated[bool, Field(description="labels have changed since the decision")]


class OverviewOut(Out):
    """The review of a recording: number of frames in each state, and all states with notes."""

    counts: dict[State, int]
    frames: list[StandingOut]
    labels: list[StandingOut]
    people: list[str]


class ReviewOut(Out):
    """A decision; null: not set by the decision."""

    first: int | None
    last: int | None
    label: LabelOrNone
    state: State | None
    note: str | None
    place: Vec3 | None
    assignee: str | None
    by: Annotated[str, Field(validation_alias="author")]
    at: Annotated[datetime, Field(validation_alias="time")]
    revision: int


@router.get("/sequences/{seq}/review", responses=responses(404))
def get_review(seq: SequenceId, workspace: Ws) -> OverviewOut:
    """Return the state of each frame and label."""
    return OverviewOut.of(workspace.reviewing.overview(seq))


@router.put("/sequences/{seq}/review", responses=responses(404, 413))
def put_review(seq: SequenceId, body: ReviewBody, workspace: Ws, who: Caller) -> OverviewOut:
    """Set state, note or assignee of frames ``first`` to ``last``, or state and note of a label.

    Accepting, rejecting and reverting these need the role reviewer; assigning frames to people
    needs the role manager.  A frame or label that is accepted or reopened loses its note.
    """
    _put(workspace, seq, who, body, body.first, body.last)
    return OverviewOut.of(workspace.reviewing.overview(seq))


@router.get("/sequences/{seq}/review/history", responses=responses(404))
def get_history(
    seq: SequenceId, workspace: Ws, limit: Annotated[int, Query(ge=1, le=1000)] = 100
) -> list[ReviewOut]:
    """Return the decisions and their authors, the newest first."""
    return [ReviewOut.of(each) for each in workspace.reviewing.history(seq)[:limit]]


@router.get("/sequences/{seq}/frames/{i}/review", responses=responses(404))
def get_frame_review(
    seq: SequenceId,
    i: FramePath,
    workspace: Ws,
    label: Annotated[int | None, Query(ge=1, le=65534, description="in this frame")] = None,
) -> StandingOut:
    """Set the state of a frame, or of a label in it."""
    return StandingOut.of(workspace.reviewing.frame(seq, i, label or 0))


@router.put("/sequences/{seq}/frames/{i}/review", responses=responses(404, 413))
def put_frame_review(
    seq: SequenceId, i: FramePath, body: FrameReviewBody, workspace: Ws, who: Caller
) -> StandingOut:
    """Set state, note or assignee of a frame, or state and note of a label in it."""
    _put(workspace, seq, who, body, i, i)
    return StandingOut.of(workspace.reviewing.frame(seq, i, body.label or 0))


def _put(
    workspace: Workspace,
    seq: str,
    who: Principal,
    body: FrameReviewBody,
    first: int | None,
    last: int | None,
) -> None:
    if body.state in DECISIONS:
        require(who.role, DECIDE)
    if body.assignee is not None:
        require(who.role, ASSIGN)
    place = None if body.place is None else (body.place[0], body.place[1], body.place[2])
    review = Review(first, last, body.label or 0, body.state, body.note, place, body.assignee)
    workspace.reviewing.put(seq, who.author, review, decides=includes(who.role, DECIDE))
