"""Objects: candidates for a click, from part to group."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from fastapi import Request
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field

from pointbrush.ranges import runs_of
from pointbrush.streaming.messages import ClipBox, LabelId, Sample
from pointbrush.web.auth import resource
from pointbrush.web.context import FramePath, SequenceId, Ws
from pointbrush.web.problems import problem_of, responses
from pointbrush.web.schemas import Body
from pointbrush.work.objects import Answer, StaleCandidateError
from pointbrush.workspace import Workspace

router = resource("objects")
Rays = Annotated[list[Sample], Field(max_length=64)]


class ObjectBody(Body):
    """Rays at an object, and at points outside it; see a stroke of shape ``object``."""

    positives: Annotated[Rays, Field(min_length=1)]
    negatives: Annotated[Rays, Field(default_factory=list)]
    radius: Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)] = 0.05
    label: LabelId = 0
    take_labelled: bool = False
    hidden: Annotated[list[LabelId], Field(max_length=65535, default_factory=list)]
    clip: ClipBox | None = None
    previous: Annotated[str, Field(max_length=64)] = ""


class CandidateOut(BaseModel):
    """Points that a click may select: ``runs`` are first number and length, in source order."""

    id: str
    level: int
    score: float
    points: int
    runs: list[tuple[int, int]]


class ObjectOut(BaseModel):
    """At most six candidates from part to group; ``first`` is the one to show first.

    ``ready``: the whole frame is prepared; else candidates come from points near the clicks.
    """

    candidates: list[CandidateOut]
    first: int
    ready: bool

    @classmethod
    def of(cls, workspace: Workspace, seq: str, i: int, answer: Answer) -> ObjectOut:
        """Return the answer of the workspace, converted from stored to source order."""
        stored = workspace.recording(seq)[i]
        return cls(
            first=answer.first,
            ready=answer.ready,
            candidates=[
                CandidateOut(
                    id=level.id, level=level.level, score=level.score, points=len(level.numbers),
                    runs=runs_of(np.sort(stored.source_index[level.numbers])).tolist(),
                )
                for level in answer.candidates
            ],
        )  # fmt: skip


@router.post("/sequences/{seq}/frames/{i}/object", responses=responses(404, 413))
def ask_object(seq: SequenceId, i: FramePath, body: ObjectBody, workspace: Ws) -> ObjectOut:
    """Return candidates for clicks on an object; a stroke of shape ``object`` takes one."""
    answer = workspace.strokes.preview(seq, i, {**body.model_dump(), "shape": "object"})
    return ObjectOut.of(workspace, seq, i, answer)


def stale_candidate(request: Request, error: Exception) -> JSONResponse:
    """Return the problem of a stroke with a void candidate, with the current candidates."""
    assert isinstance(error, StaleCandidateError)  # noqa: S101 – registered for this class
    seq, i = request.path_params["seq"], int(request.path_params["i"])
    fresh = ObjectOut.of(request.app.state.workspace, seq, i, error.answer)
    return problem_of(error, fresh.model_dump())
