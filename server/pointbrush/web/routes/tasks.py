"""The queue of a project: who labels which frames next."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from fastapi import Path, Query
from pydantic import Field

from pointbrush.labels.tasks import TaskState, Wanted
from pointbrush.roles import require
from pointbrush.streaming.messages import FrameIndex, Uuid, Vec3
from pointbrush.web.auth import Caller, Principal, resource
from pointbrush.web.context import SEQUENCE_ID, ProjectId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.roles import DECIDE
from pointbrush.web.routes.review import Note, Person
from pointbrush.web.schemas import Body, Out
from pointbrush.work.projects.queue import NewTasks
from pointbrush.work.projects.rules import Person as Asker
from pointbrush.work.projects.rules import Wish

router = resource("tasks")
TaskNumber = Annotated[int, Path(ge=1, lt=2**31, description="number of the task")]
SequenceName = Annotated[str, Field(pattern=SEQUENCE_ID, max_length=64)]


class TasksBody(Body):
    """Tasks to make: of ``recordings``, null: all of the project; ``every`` so many frames one.

    ``people`` label the same, each a copy that the others do not see; ``truth``: the labels that
    are there are hidden, and known to be right.
    """

    recordings: Annotated[list[SequenceName], Field(max_length=10_000)] | None = None
    frames: Annotated[str, Field(pattern=r"^[0-9]{0,9}(:[0-9]{0,9})?$")] | None = None
    every: Annotated[int, Field(ge=1, lt=2**31)] | None = None
    assignee: Person = ""
    people: Annotated[int, Field(ge=1, le=9)] = 1
    truth: bool = False
    id: Uuid | None = None


class NextBody(Body):
    """Work that is asked for: ``label`` frames, or ``review`` what others have labelled."""

    work: Literal["label", "review"] = "label"


class TaskPatch(Body):
    """Values to set; absent ones stay, "" takes a note or a person away."""

    state: TaskState | None = None
    assignee: Person | None = None
    note: Note | None = None
    frame: Annotated[FrameIndex, Field(description="of the place")] | None = None
    place: Annotated[Vec3, Field(description="where the note is pinned, source")] | None = None


class TaskOut(Out):
    """Frames ``first`` to ``last``, both included, of ``sequence``."""

    number: int
    sequence: str
    first: int
    last: int
    state: TaskState
    assignee: str
    reviewer: str
    note: str
    frame: int | None
    place: Vec3 | None
    created: datetime
    changed: datetime


class TaskEventOut(Out):
    """A change of a task: state, assignee and note from then on."""

    at: Annotated[datetime, Field(validation_alias="time")]
    by: Annotated[str, Field(validation_alias="author")]
    state: TaskState
    assignee: str
    note: str


def _asker(who: Principal) -> Asker:
    return Asker(who.author, who.role)


@router.get("/projects/{p}/tasks", responses=responses(404))
def list_tasks(
    p: ProjectId,
    workspace: Ws,
    who: Caller,
    state: TaskState | None = None,
    person: Annotated[str | None, Query(max_length=128, description="the assignee")] = None,
    sequence: Annotated[str | None, Query(pattern=SEQUENCE_ID, max_length=64)] = None,
    after: Annotated[int, Query(ge=0, lt=2**31, description="a task's number")] = 0,
    limit: Annotated[int, Query(ge=1, le=10_000)] = 1000,
) -> list[TaskOut]:
    """The tasks of a project, by number; who labels sees none of others' copies."""
    wanted = Wanted(state, person, sequence, after, limit)
    return [TaskOut.of(task) for task in workspace.queue.entries(p, wanted, _asker(who))]


@router.post("/projects/{p}/tasks", status_code=201, responses=responses(404, 409, 413))
def create_tasks(p: ProjectId, body: TasksBody, workspace: Ws, who: Caller) -> list[TaskOut]:
    """Make a task of each recording, or of each ``every`` frames of it.

    Frames that have a task which is not accepted yet get no other (409).  With an ``id`` the call
    can be repeated.
    """
    new = NewTasks(
        body.recordings, body.frames, body.every, body.assignee, body.people, body.truth, body.id
    )
    return [TaskOut.of(task) for task in workspace.queue.add(p, who.author, new)]


@router.post("/projects/{p}/tasks/next", responses=responses(404, 413))
def next_task(
    p: ProjectId, workspace: Ws, who: Caller, body: NextBody | None = None
) -> TaskOut | None:
    """Take the next task, which then is nobody else's; null where there is none.

    Whoever has begun one gets the same again.  Then come those returned to the caller, those meant
    for them, and free ones, the oldest first.
    """
    review = body is not None and body.work == "review"
    if review:
        require(who.role, DECIDE)
    task = workspace.queue.next(p, who.author, review=review)
    return None if task is None else TaskOut.of(task)


@router.get("/projects/{p}/tasks/{t}", responses=responses(404))
def get_task(p: ProjectId, t: TaskNumber, workspace: Ws, who: Caller) -> TaskOut:
    """One task."""
    return TaskOut.of(workspace.queue.get(p, t, _asker(who)))


@router.patch("/projects/{p}/tasks/{t}", responses=responses(404, 409, 413))
def patch_task(p: ProjectId, t: TaskNumber, body: TaskPatch, workspace: Ws, who: Caller) -> TaskOut:
    """Hand a task in, give it back, accept or return it, with a note that is pinned to a place.

    Accepting, returning and notes need the role reviewer, and another person's work; giving tasks
    to people the role manager.
    """
    place = None if body.place is None else (body.place[0], body.place[1], body.place[2])
    wish = Wish(body.state, body.assignee, body.note, body.frame, place)
    return TaskOut.of(workspace.queue.change(p, t, _asker(who), wish))


@router.delete("/projects/{p}/tasks/{t}", status_code=204, responses=responses(404))
def delete_task(p: ProjectId, t: TaskNumber, workspace: Ws) -> None:
    """Remove a task and its history; labels stay."""
    workspace.queue.remove(p, t)


@router.get("/projects/{p}/tasks/{t}/history", responses=responses(404))
def get_task_history(p: ProjectId, t: TaskNumber, workspace: Ws, who: Caller) -> list[TaskEventOut]:
    """The changes of a task, the newest first."""
    return [TaskEventOut.of(each) for each in workspace.queue.history(p, t, _asker(who))]
