"""The queue of a project: tasks to label frames, and their assignment to people."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path, Query

from pointbrush.accounts.roles import require
from pointbrush.teamwork.rules import Person as Asker
from pointbrush.teamwork.tasks import Wanted
from pointbrush.values.kinds import TaskState
from pointbrush.values.team.tasks import NewTasks, NextTask, Task, TaskEvent, TaskPatch
from pointbrush.web.context import ProjectId, RecordingQuery, Ws
from pointbrush.web.security.auth import Caller, Principal, resource
from pointbrush.web.security.roles import DECIDE, needs

router = resource("tasks")
TaskNumber = Annotated[int, Path(ge=1, lt=2**31, description="number of the task")]


def _asker(who: Principal) -> Asker:
    return Asker(who.author, who.role)


@router.get("/projects/{p}/tasks", **needs("viewer", 404))
def list_tasks(
    p: ProjectId,
    workspace: Ws,
    who: Caller,
    state: Annotated[TaskState | None, Query(description="only in this state")] = None,
    person: Annotated[str | None, Query(max_length=128, description="the assignee")] = None,
    sequence: RecordingQuery = None,
    after: Annotated[int, Query(ge=0, lt=2**31, description="a task's number")] = 0,
    limit: Annotated[int, Query(ge=1, le=10_000, description="most tasks to return")] = 1000,
) -> list[Task]:
    """List the tasks of a project by number; annotators do not see copies of other people."""
    wanted = Wanted(state, person, sequence, after, limit)
    return [*workspace.queue.entries(p, wanted, _asker(who))]


@router.post("/projects/{p}/tasks", status_code=201, **needs("manager", 404, 409, 413))
def create_tasks(p: ProjectId, body: NewTasks, workspace: Ws, who: Caller) -> list[Task]:
    """Create a task for each recording, or for each ``every`` frames of it.

    Frames with a task that is not accepted yet get no second task (409).  With an ``id`` the call
    can be repeated.
    """
    return [*workspace.queue.add(p, who.author, body)]


@router.post("/projects/{p}/tasks/next", **needs("annotator", 404, 413))
def next_task(
    p: ProjectId, workspace: Ws, who: Caller, body: NextTask | None = None
) -> Task | None:
    """Take the next task, which is then reserved for the caller; null if there is none.

    A caller with an unfinished task gets this task again.  Then follow tasks that were returned to
    the caller, tasks that are assigned to the caller, and free tasks, the oldest first.
    """
    review = body is not None and body.work == "review"
    if review:
        require(who.role, DECIDE)
    return workspace.queue.next(p, who.author, review=review)


@router.get("/projects/{p}/tasks/{t}", **needs("viewer", 404))
def get_task(p: ProjectId, t: TaskNumber, workspace: Ws, who: Caller) -> Task:
    """Return a task."""
    return workspace.queue.get(p, t, _asker(who))


@router.patch("/projects/{p}/tasks/{t}", **needs("annotator", 404, 409, 413))
def patch_task(p: ProjectId, t: TaskNumber, body: TaskPatch, workspace: Ws, who: Caller) -> Task:
    """Submit, release, accept or return a task, with a note at a position.

    Accepting, returning and notes need the role reviewer and a task of another person; assigning
    tasks to people needs the role manager.
    """
    return workspace.queue.change(p, t, _asker(who), body)


@router.delete("/projects/{p}/tasks/{t}", status_code=204, **needs("manager", 404))
def delete_task(p: ProjectId, t: TaskNumber, workspace: Ws) -> None:
    """Remove a task and its history; labels stay."""
    workspace.queue.remove(p, t)


@router.get("/projects/{p}/tasks/{t}/history", **needs("viewer", 404))
def get_task_history(p: ProjectId, t: TaskNumber, workspace: Ws, who: Caller) -> list[TaskEvent]:
    """List the changes of a task, the newest first."""
    return workspace.queue.history(p, t, _asker(who))
