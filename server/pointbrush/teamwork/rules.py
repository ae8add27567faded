"""The steps of a task between states, and the roles that may make them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

from pointbrush.accounts.roles import Role, includes
from pointbrush.errors import BadInputError, ConflictError, ForbiddenError
from pointbrush.teamwork.reviews import Place
from pointbrush.teamwork.tasks import TASK_STATES, Task
from pointbrush.values.kinds import TaskState
from pointbrush.values.team.tasks import TaskPatch

Maker = Literal["anyone", "assignee", "reviewer"]
LEADS: Role = "manager"
"""Role that may make every step and assign tasks."""
DECIDES: Role = "reviewer"
"""Role that reviews others' work."""
LONGEST_NOTE = 2_000
"""Longest note, characters."""

STEPS: Mapping[tuple[TaskState, TaskState], Maker] = {
    ("open", "taken"): "anyone",
    ("taken", "open"): "assignee",
    ("taken", "done"): "assignee",
    ("done", "taken"): "assignee",
    ("returned", "taken"): "assignee",
    ("returned", "open"): "assignee",
    ("done", "review"): "reviewer",
    ("review", "done"): "reviewer",
    ("done", "accepted"): "reviewer",
    ("review", "accepted"): "reviewer",
    ("done", "returned"): "reviewer",
    ("review", "returned"): "reviewer",
    ("accepted", "returned"): "reviewer",
    ("accepted", "done"): "reviewer",
}
"""The steps for roles below LEADS; ``anyone`` includes annotators."""
_LEADS_ALONE = frozenset((state, "open") for state in TASK_STATES)


@dataclass(frozen=True, slots=True)
class Person:
    """The account of a caller, and its role in the project."""

    account: str
    role: Role


def fulfilled(task: Task, wish: TaskPatch, who: Person) -> Task:
    """Return a task with the changes that ``who`` requests; equal values are no change.

    Raises ForbiddenError for a step that ``who`` may not make, ConflictError for an invalid step,
    BadInputError.
    """
    _check(task, wish)
    if wish.assignee is not None and wish.assignee != task.assignee:
        if not includes(who.role, LEADS):
            raise ForbiddenError(f"assignee: expected the role {LEADS}, yours here is {who.role}")
        task = replace(task, assignee=wish.assignee)
    if wish.state is not None and wish.state != task.state:
        _require_step(task, wish.state, who)
        task = _stepped(task, wish.state, who)
    if wish.note is not None and (wish.note, wish.frame, wish.place) != _pinned(task):
        if not includes(who.role, DECIDES):
            raise ForbiddenError(f"note: expected the role {DECIDES}, yours here is {who.role}")
        task = replace(task, note=wish.note, frame=wish.frame, place=wish.place)
    if task.state in ("taken", "done") and not task.assignee:
        raise ConflictError(f"assignee: expected a person for a task that is {task.state}")
    return task


def _pinned(task: Task) -> tuple[str, int | None, Place | None]:
    return task.note, task.frame, task.place


def _require_step(task: Task, state: TaskState, who: Person) -> None:
    maker = STEPS.get((task.state, state))
    if includes(who.role, LEADS) and (maker or (task.state, state) in _LEADS_ALONE):
        return
    if maker is None:
        steps = [to for (of, to) in STEPS if of == task.state]
        raise ConflictError(
            f"state: expected one of {', '.join(steps)} for a task that is {task.state}, "
            f"got {state}"
        )
    if maker == "reviewer":
        _require_reviewer(task, who)
    elif task.assignee != who.account and (maker == "assignee" or task.assignee):
        raise ForbiddenError(f"task: expected your own task, {task.number} is another person's")


def _require_reviewer(task: Task, who: Person) -> None:
    if not includes(who.role, DECIDES):
        raise ForbiddenError(f"state: expected the role {DECIDES}, yours here is {who.role}")
    if task.assignee == who.account:
        raise ForbiddenError(f"task: expected another person's task, {task.number} is your own")
    if task.state == "review" and task.reviewer not in ("", who.account):
        raise ForbiddenError(f"task: another person reviews {task.number}")


def _stepped(task: Task, state: TaskState, who: Person) -> Task:
    task = replace(task, state=state)
    if state == "open":
        return replace(task, assignee="", reviewer="")
    if state == "taken":
        return replace(task, assignee=task.assignee or who.account)
    if state == "done":
        return replace(task, reviewer="")
    task = replace(task, reviewer=who.account)
    # An accepted task keeps no note about faults.
    return replace(task, note="", frame=None, place=None) if state == "accepted" else task


def _check(task: Task, wish: TaskPatch) -> None:
    if wish.state is None and wish.note is None and wish.assignee is None:
        raise BadInputError("expected a state, a note or an assignee, got none of them")
    if wish.note is not None and len(wish.note) > LONGEST_NOTE:
        raise BadInputError(
            f"note: expected at most {LONGEST_NOTE} characters, got {len(wish.note)}"
        )
    if (wish.place is None) != (wish.frame is None):
        raise BadInputError("place: expected together with its frame")
    if wish.frame is not None:
        if not wish.note:
            raise BadInputError("place: expected a note to pin there, got none")
        if not task.first <= wish.frame <= task.last:
            raise BadInputError(
                f"frame: expected one of the task, {task.first} to {task.last}, got {wish.frame}"
            )
