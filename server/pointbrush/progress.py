"""A job's progress on the command line: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from typing import Any

from tqdm import tqdm

from pointbrush.errors import CancelledError, PointbrushError
from pointbrush.jobs import ENDED, Job
from pointbrush.workspace import Workspace

TICK = 0.1
LINE_STEP = 0.1
"""Share of the work between two plain lines."""


def follow(workspace: Workspace, job: Job) -> dict[str, Any]:
    """Show ``job`` until it has ended; returns its result.

    Raises PointbrushError with the job's own sentence when it failed, CancelledError when it was
    cancelled.
    """
    show = _bar if sys.stderr.isatty() else _lines
    ended = show(workspace, job)
    if ended.state == "failed":
        raise PointbrushError(ended.error or "the job failed")
    if ended.state == "cancelled":
        raise CancelledError("cancelled")
    return ended.result or {}


def _bar(workspace: Workspace, job: Job) -> Job:
    layout = "{desc}: {percentage:3.0f}% |{bar}| {postfix}"
    with tqdm(total=1.0, desc=job.kind, bar_format=layout, leave=True) as bar:
        while job.state not in ENDED:
            time.sleep(TICK)
            job = workspace.job(job.id)
            bar.set_postfix_str(job.message, refresh=False)
            bar.update(job.progress - bar.n)
    return job


def _lines(workspace: Workspace, job: Job) -> Job:
    shown = -1.0
    while job.state not in ENDED:
        time.sleep(TICK)
        job = workspace.job(job.id)
        if job.state == "running" and job.progress >= shown + LINE_STEP:
            shown = job.progress
            print(f"{job.kind}: {job.progress:.0%} {job.message}", file=sys.stderr, flush=True)
    return job
