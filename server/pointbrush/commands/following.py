"""Progress of jobs on the command line: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from pointbrush.database.job import ENDED
from pointbrush.errors import CancelledError, PointbrushError

if TYPE_CHECKING:
    from pointbrush import client
    from pointbrush.database import job

TICK = 0.1
"""Seconds between two polls."""
LINE_STEP = 0.1
"""Part of the work between two plain lines, 0..1."""
Job: TypeAlias = "job.Job | client.Job"
"""A job of this process, or of a server."""
Look: TypeAlias = Callable[[str], Job]
"""Return the current state of a job, by its id."""


def follow(look: Look, job: Job) -> dict[str, Any]:
    """Show ``job`` until it has ended, and return its result.

    Raises PointbrushError with the error of a failed job, CancelledError for a cancelled job.
    """
    show = _bar if sys.stderr.isatty() else _lines
    ended = show(look, job)
    if ended.state == "failed":
        raise PointbrushError(ended.error or "the job failed")
    if ended.state == "cancelled":
        raise CancelledError("cancelled")
    return ended.result or {}


def _bar(look: Look, job: Job) -> Job:
    from tqdm import tqdm

    layout = "{desc}: {percentage:3.0f}% |{bar}| {postfix}"
    with tqdm(total=1.0, desc=job.kind, bar_format=layout, leave=True) as bar:
        while job.state not in ENDED:
            time.sleep(TICK)
            job = look(job.id)
            bar.set_postfix_str(job.message, refresh=False)
            bar.update(job.progress - bar.n)
    return job


def _lines(look: Look, job: Job) -> Job:
    shown = -1.0
    while job.state not in ENDED:
        time.sleep(TICK)
        job = look(job.id)
        if job.state == "running" and job.progress >= shown + LINE_STEP:
            shown = job.progress
            print(f"{job.kind}: {job.progress:.0%} {job.message}", file=sys.stderr, flush=True)
    return job
