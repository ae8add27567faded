"""Sensors of a recording."""

from __future__ import annotations

from fastapi import Response

from pointbrush.values.jobs import Job
from pointbrush.values.sensors import SensorAlignment
from pointbrush.web.context import SequenceId, Ws
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs

router = resource("sensors")


@router.post("/sequences/{seq}/sensors/align", status_code=202, **needs("manager", 404, 409))
def align_sensors(
    seq: SequenceId, body: SensorAlignment, response: Response, workspace: Ws, who: Caller
) -> Job:
    """Correct the mounts of the sensors by surfaces that several of them see, in a job.

    The first sensor stays where it is.  With ``undo``, the mounts of before the last alignment are
    restored.
    """
    job = workspace.aligning.start(seq, body.frames, author=who.author, undo=body.undo, job=body.id)
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return job
