"""Jobs."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query

from pointbrush.accounts.roles import require
from pointbrush.errors import NotFoundError
from pointbrush.values.jobs import Job
from pointbrush.web.context import JobPath, Ws
from pointbrush.web.security.auth import Caller, TheGate, resource
from pointbrush.web.security.roles import CANCEL_ANY, needs

router = resource("jobs")


@router.get("/jobs", **needs("viewer"))
def list_jobs(workspace: Ws, who: Caller, gate: TheGate) -> list[Job]:
    """List the jobs of recordings that the caller may open, the newest first."""
    return [job for job in workspace.jobs.all() if gate.may_see_job(who, job)]


@router.get("/jobs/{id}", **needs("viewer", 404))
def get_job(id: JobPath, workspace: Ws, who: Caller, gate: TheGate) -> Job:
    """Return a job."""
    job = workspace.jobs.get(id.lower())
    if not gate.may_see_job(who, job):
        raise NotFoundError(f"job: expected a known id, got {id}")
    return job


@router.delete("/jobs/{id}", **needs("annotator", 404, 409))
def cancel_job(
    id: JobPath,
    workspace: Ws,
    who: Caller,
    keep: Annotated[
        bool, Query(description="commit the frames that a tracking run has finished")
    ] = False,
) -> Job:
    """Ask a job to stop: the caller's own job, or any job with the role manager."""
    if workspace.jobs.get(id.lower()).owner != who.author:
        require(who.role, CANCEL_ANY)
    return Job.of(workspace.jobs.cancel(id.lower(), keep=keep))
