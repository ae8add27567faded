"""People found in colour pictures, without a click."""

from __future__ import annotations

from dataclasses import asdict

from fastapi.responses import JSONResponse

from pointbrush.values.jobs import Job
from pointbrush.values.people import FoundPeople, PeopleSearch
from pointbrush.web.context import RunOrder, SequenceId, Ws
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs

router = resource("people")


@router.post(
    "/sequences/{seq}/people",
    **needs(
        "annotator", 404, 409, answers={202: {"model": Job, "description": "Job that labels them"}}
    ),
)
def find_people(
    seq: SequenceId,
    body: PeopleSearch,
    workspace: Ws,
    who: Caller,
    format: RunOrder = "source",
) -> FoundPeople:
    """Find the people in frames; with ``apply``, label them in a job: one edit of provenance 4.

    Painted, erased and tracked points keep their labels.
    """
    if not body.apply:
        return workspace.people.find(seq, body.frames, stored=format == "stored")
    job = workspace.people.start(seq, body.frames, author=who.author, edit=body.id)
    place = {"Location": f"/api/v1/jobs/{job.id}"}
    return JSONResponse(asdict(Job.of(job)), 202, place)  # type: ignore[return-value]
