"""Events of a recording, for scripts that react to them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Annotated

from fastapi import Query, Request

from pointbrush.values.jobs import Job
from pointbrush.values.tracking import Events
from pointbrush.web.context import WholeSequence, Ws
from pointbrush.web.routes.edits import past_edit
from pointbrush.web.routes.tracking import track_of
from pointbrush.web.security.auth import resource
from pointbrush.web.security.roles import needs
from pointbrush.web.watching import Watching
from pointbrush.work.doubts import is_doubtful
from pointbrush.workspace import Workspace

router = resource("edits")
LONGEST_WAIT = 50.0
"""Seconds; proxies give up an answer that does not begin in a minute."""
MOST_EDITS = 500
TRACKING = "tracking"


@router.get("/sequences/{seq}/events", **needs("viewer", 404))
async def wait_for_events(
    seq: WholeSequence,
    request: Request,
    workspace: Ws,
    after: Annotated[
        int | None, Query(ge=0, lt=2**53, description="a revision; none: the current one")
    ] = None,
    jobs_seen: Annotated[
        str | None,
        Query(max_length=64, description="of the previous answer; none: return all jobs"),
    ] = None,
    wait: Annotated[float, Query(ge=0, le=LONGEST_WAIT, description="seconds")] = 0.0,
) -> Events:
    """Wait for edits and changes of jobs; the answer is empty if nothing happens within ``wait``.

    With the ``revision`` and ``jobs_seen`` of the previous answer a client misses nothing, even if
    the connection was lost or the server restarted.
    """
    watching: Watching = request.app.state.watching

    def look() -> tuple[Events, bool]:
        events = happened(workspace, seq, after, jobs_seen)
        return events, bool(events.edits or events.jobs) or after is None

    return await watching.until(seq, look, wait)


def happened(workspace: Workspace, seq: str, after: int | None, jobs_seen: str | None) -> Events:
    """Collect the edits after a revision, and the jobs if any differs from ``jobs_seen``."""
    access = workspace.labels.team.access
    mine = (job for job in workspace.jobs.all() if job.sequence == seq)
    jobs = [job for job in mine if access.is_of(seq, job.created)]
    digest = _digest(jobs)
    revision = workspace.labels.revision(seq) if after is None else after
    later = workspace.labels.edits(seq, after=revision, limit=MOST_EDITS)
    edits = tuple(past_edit(edit, workspace) for edit in later)
    tracked = {frame for edit in edits if edit.kind == TRACKING for frame in edit.frames}
    doubts = tuple(
        track_of(track)
        for track in (workspace.labels.tracks(seq) if tracked else ())
        if track["frame"] in tracked and is_doubtful(track)
    )
    return Events(
        edits[-1].revision if edits else revision,
        digest,
        edits,
        doubts,
        () if digest == jobs_seen else tuple(jobs),
    )


def _digest(jobs: Sequence[Job]) -> str:
    states = [(job.id, job.state, job.progress, job.message) for job in jobs]
    return hashlib.sha256(repr(states).encode()).hexdigest()[:16]
