"""The queue of a project: tasks to label frames, and their assignment to people."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from fastapi import Path, Query
from pydantic import Field

from pointbrush.accounts.roles import require
from pointbrush.streaming.messages import FrameIndex, Uuid, Vec3
from pointbrush.teamwork.rules import Person as Asker
from pointbrush.teamwork.rules import Wish
from pointbrush.teamwork.tasks import TaskState, Wanted
from pointbrush.web.auth import Caller, Principal, resource
from pointbrush.web.context import SEQUENCE_ID, ProjectId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.roles import DECIDE
from pointbrush.web.routes.review import Note, Person
from pointbrush.web.schemas import Body, Out
from pointbrush.work.projects.queue import NewTasks

router = resource("tasks")
TaskNumber = Annotated[int, Path(ge=1, lt=2**31, description="number of the task")]
SequenceName = Annotated[str, Field(pattern=SEQUENCE_ID, max_length=64)]


class TasksBody(Body):
    """Tasks to create: for ``recordings`` (null: all of the project), each of ``every`` frames.

    ``people``: so many people label the same frames, each in a copy that the others do not see.
    ``truth``: the existing labels are hidden and count as ground truth.
    """

    recordings: Annotated[list[SequenceName], Field(max_length=10_000)] | None = None
    frames: Annotated[str, Field(pattern=r"^[0-9]{0,9}(:[0-9]{0,9})?$")] | None = None
    every: Annotated[int, Field(ge=1, lt=2**31)] | None = None
    assignee: Person = ""
    people: Annotated[int, Field(ge=1, le=9)] = 1
    truth: bool = False
    id: Uuid | None = None


class NextBody(Body):
    """The kind of work: ``label`` frames, or ``review`` the labels of other people."""

    work: Literal["label", "review"] = "label"


class TaskPatch(Body):
    """Values to set; missing fields do not change, "" removes a note or an assignee."""

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
    """A change of a task: its new state, assignee and note."""

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
    """List the tasks of a project by number; annotators do not see copies of other people."""
    wanted = Wanted(state, person, sequence, after, limit)
    return [TaskOut.of(task) for task in workspace.queue.entries(p, wanted, _asker(who))]


@router.post("/projects/{p}/tasks", status_code=201, responses=responses(404, 409, 413))
def create_tasks(p: ProjectId, body: TasksBody, workspace: Ws, who: Caller) -> list[TaskOut]:
    """Create a task for each recording, or for each ``every`` frames of it.

    Frames with a task that is not accepted yet get no second task (409).  With an ``id`` the call
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
    """Take the next task, which is then reserved for the caller; null if there is none.

    A caller with an unfinished task gets this task again.  Then follow tasks that were returned to
    the caller, tasks that are assigned to the caller, and free tasks, the oldest first.
    """
    review = body is not None and body.work == "review"
    if review:
        require(who.role, DECIDE)
    task = workspace.queue.next(p, who.author, review=review)
    return None if task is None else TaskOut.of(task)


@router.get("/projects/{p}/tasks/{t}", responses=responses(404))
def get_task(p: ProjectId, t: TaskNumber, workspace: Ws, who: Caller) -> TaskOut:
    """Return a task."""
    return TaskOut.of(workspace.queue.get(p, t, _asker(who)))


@router.patch("/projects/{p}/tasks/{t}", responses=responses(404, 409, 413))
def patch_task(p: ProjectId, t: TaskNumber, body: TaskPatch, workspace: Ws, who: Caller) -> TaskOut:
    """Submit, release, accept or return a task, with a note at a position.

    Accepting, returning and notes need the role reviewer and a task of another person; assigning
    tasks to people needs the role manager.
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
    """List the changes of a task, the newest first."""
    return [TaskEventOut.of(each) for each in workspace.queue.history(p, t, _asker(who))]
