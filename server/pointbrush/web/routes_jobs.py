"""Long work."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from pointbrush.web.auth import Annotator, Viewer
from pointbrush.web.context import JobPath, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas_work import JobOut

router = APIRouter(tags=["jobs"])


@router.get("/jobs", responses=responses())
def list_jobs(workspace: Ws, _who: Viewer) -> list[JobOut]:
    """All remembered jobs, newest first."""
    return [JobOut.of(job) for job in workspace.jobs()]


@router.get("/jobs/{id}", responses=responses(404))
def get_job(id: JobPath, workspace: Ws, _who: Viewer) -> JobOut:
    """One job."""
    return JobOut.of(workspace.job(id.lower()))


@router.delete("/jobs/{id}", responses=responses(404, 409))
def cancel_job(
    id: JobPath,
    workspace: Ws,
    _who: Annotator,
    keep: Annotated[bool, Query(description="commit what a tracking run has found")] = False,
) -> JobOut:
    """Ask a job to stop."""
    return JobOut.of(workspace.cancel(id.lower(), keep=keep))
