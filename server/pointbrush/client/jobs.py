"""Long work: how it is waited for."""

from __future__ import annotations

from typing import Any

from tqdm import tqdm

from pointbrush import errors
from pointbrush.client.steps import Pause, Request, Steps, send
from pointbrush.client.values import Job, read

POLL_SECONDS = 0.2
"""Between two looks at a job."""
ENDED = ("done", "failed", "cancelled")


def job_now(job: str) -> Steps[Job]:
    """Return a job as it is now."""
    answer = yield from send(Request("GET", f"/jobs/{job}", again=True))
    return read(Job, answer.json())


def finished(job: Job, *, progress: bool) -> Steps[dict[str, Any]]:
    """Wait for a job; returns its result.  ``progress`` shows a bar.

    Raises PointbrushError with the job's sentence, CancelledError.
    """
    with tqdm(total=100, disable=not progress, unit="%", desc=job.kind) as bar:
        while job.state not in ENDED:
            yield Pause(POLL_SECONDS)
            job = yield from job_now(job.id)
            bar.update(round(100 * job.progress) - bar.n)
    if job.state == "failed":
        raise errors.PointbrushError(job.error or "the job failed")
    if job.state == "cancelled":
        raise errors.CancelledError("the job was cancelled")
    return job.result or {}
