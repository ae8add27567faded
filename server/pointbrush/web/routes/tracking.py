"""Tracking runs and their tracks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Annotated, Any

from fastapi import Response

from pointbrush.tracking import METHODS
from pointbrush.values.base import Patterns
from pointbrush.values.edits import Edit
from pointbrush.values.jobs import Job
from pointbrush.values.runs import Acceptance, Clearing, Copying, Stretch, TrackingRequest
from pointbrush.values.tracking import Track
from pointbrush.web.context import FramePath, SequenceId, WholeSequence, Ws, one_of
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs

router = resource("tracking")


@router.post("/sequences/{seq}/tracking", status_code=202, **needs("annotator", 404, 409, 413))
def start_tracking(
    seq: SequenceId,
    body: Annotated[TrackingRequest, Patterns(method=one_of(METHODS))],
    response: Response,
    workspace: Ws,
    who: Caller,
) -> Job:
    """Carry labels from frame ``start`` to ``stop`` in a job; the run is one edit."""
    job = workspace.tracking.start(seq, body, who.author)
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return job


@router.post("/sequences/{seq}/frames/{i}/accept", **needs("reviewer", 404, 409))
def accept(seq: SequenceId, i: FramePath, body: Acceptance, workspace: Ws, who: Caller) -> Edit:
    """Mark the tracked points of labels in this frame as painted; one edit."""
    return workspace.verdicts.give("accept", seq, [i], body.labels, who.author, body.id)


@router.post("/sequences/{seq}/frames/{i}/copy", **needs("annotator", 404, 409))
def copy(seq: SequenceId, i: FramePath, body: Copying, workspace: Ws, who: Caller) -> Edit:
    """Copy labels from the points at the same place in another frame; one edit."""
    return workspace.copying.copy(seq, i, body.source, body.labels, who.author, body.id)


@router.post("/sequences/{seq}/frames/{i}/clear", **needs("annotator", 404, 409))
def clear(seq: SequenceId, i: FramePath, body: Clearing, workspace: Ws, who: Caller) -> Edit:
    """Remove labels from all their points in a range of frames, painted points included; one edit.

    `POST /sequences/{seq}/clear` keeps painted points.
    """
    stop = i if body.stop is None else body.stop
    frames = range(min(i, stop), max(i, stop) + 1)
    return workspace.copying.clear(seq, frames, body.labels, who.author, body.id)


@router.post("/sequences/{seq}/accept", **needs("reviewer", 404, 409))
def accept_stretch(seq: SequenceId, body: Stretch, workspace: Ws, who: Caller) -> Edit:
    """Mark the tracked points of labels in a range of frames as painted; one edit."""
    return workspace.verdicts.give("accept", seq, body.frames, body.labels, who.author, body.id)


@router.post("/sequences/{seq}/clear", **needs("annotator", 404, 409))
def clear_stretch(seq: SequenceId, body: Stretch, workspace: Ws, who: Caller) -> Edit:
    """Remove labels from their tracked points in a range of frames; one edit.

    Painted points stay, and the frames are no longer in doubt.
    `POST /sequences/{seq}/frames/{i}/clear` also removes painted points.
    """
    return workspace.verdicts.give("clear", seq, body.frames, body.labels, who.author, body.id)


@router.get("/sequences/{seq}/tracks", **needs("viewer", 404))
def list_tracks(seq: WholeSequence, workspace: Ws) -> list[Track]:
    """Return pose, confidence and state of every tracked label in every frame."""
    return [track_of(track) for track in workspace.labels.tracks(seq)]


def track_of(stored: Mapping[str, Any]) -> Track:
    """Return a stored track, which may have further entries."""
    return Track(**{each.name: stored[each.name] for each in fields(Track)})
