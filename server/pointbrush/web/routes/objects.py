"""Objects: candidates for a click, from part to group."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
from fastapi import Request
from fastapi.responses import JSONResponse

from pointbrush.ranges import runs_of
from pointbrush.values.objects import Candidate, Candidates
from pointbrush.web.context import FramePath, SequenceId, Ws
from pointbrush.web.problems import problem_of
from pointbrush.web.security.auth import resource
from pointbrush.web.security.roles import needs
from pointbrush.web.strokes import ObjectBody
from pointbrush.work.objects.service import Answer, StaleCandidateError
from pointbrush.workspace import Workspace

router = resource("objects")


@router.post("/sequences/{seq}/frames/{i}/object", **needs("annotator", 404, 413))
def ask_object(seq: SequenceId, i: FramePath, body: ObjectBody, workspace: Ws) -> Candidates:
    """Return candidates for clicks on an object; a stroke of shape ``object`` takes one."""
    answer = workspace.strokes.preview(seq, i, {**body.model_dump(), "shape": "object"})
    return _candidates(workspace, seq, i, answer)


def _candidates(workspace: Workspace, seq: str, i: int, answer: Answer) -> Candidates:
    """Return an answer of the workspace, converted from stored to source order."""
    source = workspace.recording(seq)[i].source_index
    found = (
        Candidate(
            level.id, level.level, level.score, len(level.numbers),
            tuple(map(tuple, runs_of(np.sort(source[level.numbers])).tolist())),
        )
        for level in answer.candidates
    )  # fmt: skip
    return Candidates(tuple(found), answer.first, answer.ready)


def stale_candidate(request: Request, error: Exception) -> JSONResponse:
    """Return the problem of a stroke with a void candidate, with the current candidates."""
    assert isinstance(error, StaleCandidateError)  # noqa: S101 – registered for this class
    seq, i = request.path_params["seq"], int(request.path_params["i"])
    fresh = _candidates(request.app.state.workspace, seq, i, error.answer)
    return problem_of(error, asdict(fresh))
