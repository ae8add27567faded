"""Agreement of people with the same points to label, merging of their work, and ground truth."""

from __future__ import annotations

from typing import Annotated

from pointbrush.values.edits import Edit
from pointbrush.values.team.tasks import CopyAgreement, CopyMerge, Score
from pointbrush.web.context import ProjectId, Ws, id_query
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs

router = resource("agreement")
Whole = Annotated[str, id_query("the recording that has copies")]


@router.get("/projects/{p}/agreement", **needs("reviewer", 404))
def get_agreement(p: ProjectId, sequence: Whole, workspace: Ws) -> list[CopyAgreement]:
    """Compare the copies of a recording in pairs, in frames that both people have submitted."""
    return workspace.agreeing.compare(p, sequence)


@router.post("/projects/{p}/merge", **needs("reviewer", 404, 409, 413))
def merge(p: ProjectId, body: CopyMerge, workspace: Ws, who: Caller) -> Edit:
    """Write the labels of one copy, or of the majority, into the recording, as one edit."""
    return workspace.agreeing.merge(
        p, body.sequence, body.take, who.author, edit_id=body.id, region=body.region
    )


@router.get("/projects/{p}/scores", **needs("reviewer", 404))
def get_scores(p: ProjectId, workspace: Ws) -> list[Score]:
    """Compare the submitted labels of each person with the ground truth, the best first."""
    return workspace.agreeing.scores(p)
