"""Studies of labelling: for their experimenters, and for participants, whom a code admits."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

from fastapi import APIRouter, Depends, Path, Query, Request, Response

from pointbrush.values.study import (
    FileKind,
    LogPosition,
    LogRecords,
    NewParticipants,
    NewStudy,
    Participant,
    ParticipantPatch,
    Replay,
    StepDone,
    StudyInfo,
    StudyStep,
)
from pointbrush.web.context import SEQUENCE_ID, Ws, known_query
from pointbrush.web.problems import responses
from pointbrush.web.security.auth import TheGate, resource
from pointbrush.web.security.cookies import set_cookie
from pointbrush.web.security.roles import PREFIX, needs, needs_for_file
from pointbrush.work.reviewing.report.html import POLICY

router = resource("studies")
participant_router = APIRouter(prefix=PREFIX, tags=["studies"], dependencies=[Depends(known_query)])
StudyId = Annotated[str, Path(pattern=SEQUENCE_ID, max_length=64, description="study id")]
Key = Annotated[
    str, Path(pattern=r"^[\w-]{1,64}$", description="number or code of the participant")
]
Table = Annotated[
    FileKind, Query(alias="format", description="kind of file: `csv`, `parquet` or `json`")
]
MEDIA_TYPES = {
    "csv": "text/csv",
    "parquet": "application/vnd.apache.parquet",
    "json": "application/json",
}


@router.get("/studies", **needs("manager"))
def list_studies(workspace: Ws) -> list[StudyInfo]:
    """List the studies by id."""
    return workspace.studies.all()


@router.post("/studies", status_code=201, **needs("manager", 404, 409, 413))
def create_study(body: NewStudy, response: Response, workspace: Ws) -> StudyInfo:
    """Create a study from a text or a template.

    Samples that its tasks name are generated, which takes about a second for each frame.
    """
    made = workspace.studies.create(body)
    response.headers["Location"] = f"{PREFIX}/studies/{made.id}"
    return made


@router.get("/studies/{s}", **needs("manager", 404))
def get_study(s: StudyId, workspace: Ws) -> StudyInfo:
    """Return a study."""
    return workspace.studies.get(s)


@router.put("/studies/{s}", **needs("manager", 404, 409, 413))
def put_study(s: StudyId, body: NewStudy, workspace: Ws) -> StudyInfo:
    """Replace a study that has no participants."""
    return workspace.studies.change(s, body)


@router.delete("/studies/{s}", status_code=204, **needs("manager", 404))
def delete_study(s: StudyId, workspace: Ws) -> None:
    """Remove a study and every trace of its participants."""
    workspace.studies.remove(s)


@router.get("/studies/{s}/participants", **needs("manager", 404))
def list_participants(s: StudyId, workspace: Ws) -> list[Participant]:
    """List the participants of a study by number, with their current steps."""
    return workspace.studies.participants(s)


@router.post("/studies/{s}/participants", status_code=201, **needs("manager", 404, 409, 413))
def add_participants(
    s: StudyId, body: NewParticipants, request: Request, workspace: Ws
) -> list[Participant]:
    """Add participants; their codes are in this answer only."""
    page = str(request.base_url).rstrip("/")
    added = workspace.studies.add(s, body.count)
    return [replace(each, link=f"{page}/study/{each.code}") for each in added]


@router.patch("/studies/{s}/participants/{n}", **needs("manager", 404, 413))
def patch_participant(s: StudyId, n: Key, body: ParticipantPatch, workspace: Ws) -> Participant:
    """Pause or continue the session of a participant."""
    return workspace.studies.pause(s, n, paused=body.paused)


@router.delete("/studies/{s}/participants/{n}", status_code=204, **needs("manager", 404))
def delete_participant(s: StudyId, n: Key, workspace: Ws) -> None:
    """Remove every trace of a participant: session, answers, log, labels and copies."""
    workspace.studies.erase(s, n)


@router.get(
    "/studies/{s}/results", **needs_for_file("manager", "The results", *MEDIA_TYPES.values())
)
def get_results(
    s: StudyId,
    workspace: Ws,
    kind: Table = "csv",
    table: Annotated[
        Literal["tasks", "curves"],
        Query(description="`tasks`: a row per participant and task; `curves`: IoU over time"),
    ] = "tasks",
) -> Response:
    """Return the measures of finished tasks."""
    return _table(workspace.studies.results(s, kind, curves=table == "curves"), kind)


@router.get("/studies/{s}/report", **needs_for_file("manager", "The report", "text/html"))
def get_study_report(s: StudyId, workspace: Ws) -> Response:
    """Return plots, effect sizes and their bootstrap intervals as a page."""
    headers = {"Content-Security-Policy": POLICY}
    return Response(workspace.studies.report(s), media_type="text/html", headers=headers)


@router.get(
    "/studies/{s}/participants/{n}/log",
    **needs_for_file("manager", "The log", *MEDIA_TYPES.values()),
)
def get_log(s: StudyId, n: Key, workspace: Ws, kind: Table = "csv") -> Response:
    """Return all records of a participant; as JSON, as the page sent them."""
    return _table(workspace.studies.log(s, n, kind), kind)


@router.get("/studies/{s}/participants/{n}/steps", **needs("manager", 404))
def list_steps(s: StudyId, n: Key, workspace: Ws) -> list[StudyStep]:
    """List the steps of a participant that have labels, by number."""
    return workspace.studies.steps(s, n)


@router.post("/studies/{s}/participants/{n}/replay", **needs("manager", 404))
def replay_session(s: StudyId, n: Key, workspace: Ws) -> Replay:
    """Apply the log to new labels, and compare them with those of the participant."""
    return workspace.studies.replay(s, n)


def _table(content: bytes, kind: FileKind) -> Response:
    return Response(content, media_type=MEDIA_TYPES[kind])


# ── for participants, whom the code in the path admits ───────────────────────────────────


def participant(
    request: Request,
    code: Annotated[str, Path(pattern=r"^[\w-]{1,64}$", description="code of the participant")],
    gate: TheGate,
) -> str:
    """Return the account of a code; raises UnauthorizedError, TooManyRequestsError."""
    return gate.participant(code, request)


Account = Annotated[str, Depends(participant)]
_ERRORS = responses(401, 409, 413)


@participant_router.post("/study/{code}", responses=_ERRORS)
def enter_study(
    code: str, account: Account, request: Request, response: Response, workspace: Ws, gate: TheGate
) -> StudyStep:
    """Exchange a code for the page's cookie, which opens the participant's copies alone."""
    set_cookie(request, response, gate.participant_cookie(code, request))
    return workspace.studies.step(account)


@participant_router.get("/study/{code}/step", responses=_ERRORS)
def get_step(account: Account, workspace: Ws) -> StudyStep:
    """Return the current step."""
    return workspace.studies.step(account)


@participant_router.post("/study/{code}/step", responses=_ERRORS)
def finish_step(body: StepDone, account: Account, workspace: Ws) -> StudyStep:
    """End a step and return the next one; the call can be repeated."""
    return workspace.studies.finish(account, body)


@participant_router.post("/study/{code}/log", responses=_ERRORS)
def append_log(body: LogRecords, account: Account, workspace: Ws) -> LogPosition:
    """Append records to the log, numbered without gaps; the call can be repeated."""
    return workspace.studies.append(account, body)
