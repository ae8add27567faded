"""The queue of a project: tasks to label and then review ranges of frames.

Each change of a queue locks its project's row first, so that a task is assigned only once, even
with several servers.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, get_args

from sqlalchemy import (
    ColumnElement,
    Connection,
    Row,
    Select,
    case,
    func,
    insert,
    select,
    update,
)

from pointbrush.database.database import Database
from pointbrush.database.lost_answers import write_once
from pointbrush.database.project_rows import forget_tasks, lock_project
from pointbrush.database.project_tables import task_events, tasks
from pointbrush.database.schema import LIVE, PROJECT_OF, sequences
from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.teamwork.copies import seen_elsewhere
from pointbrush.teamwork.webhooks import announce
from pointbrush.values.kinds import TaskState, time_of
from pointbrush.values.team import tasks as values
from pointbrush.values.team.tasks import TaskEvent

TASK_STATES: tuple[TaskState, ...] = get_args(get_args(TaskState)[0])
"""Unassigned; being labelled; labelled; being reviewed; accepted; to be labelled again."""

MOST_TASKS = 100_000
"""Limit for a project, with accepted tasks, as taking the next task reads all of them."""


@dataclass(frozen=True, slots=True)
class Task(values.Task):
    """A task of a project; ``assignee`` and ``reviewer`` are accounts, or ""."""

    project: str


@dataclass(frozen=True, slots=True)
class Stretch:
    """Frames ``first`` to ``last`` of a recording, for a new task."""

    sequence: str
    first: int
    last: int


@dataclass(frozen=True, slots=True)
class Wanted:
    """Conditions on tasks; None: any.  ``after``: a number; ``limit``: of the result.

    ``without``: ids of recordings to exclude.
    """

    state: TaskState | None = None
    assignee: str | None = None
    sequence: str | None = None
    after: int = 0
    limit: int = 1000
    without: Collection[str] = ()


class Tasks:
    """The tasks of all projects of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(
        self,
        project: str,
        author: str,
        stretches: Sequence[Stretch],
        *,
        assignee: str = "",
        batch: str | None = None,
    ) -> list[Task]:
        """Create tasks; for a repeated ``batch`` return the tasks that it has created.

        Raises NotFoundError (project, recording of it), ConflictError for frames that have a task
        already, BadInputError for too many tasks.
        """

        def make(connection: Connection) -> list[Task]:
            lock_project(connection, project)
            made = _batch(connection, project, batch)
            return made or self._add(connection, project, author, stretches, assignee, batch)

        return write_once(self._database, make, lambda c: _batch(c, project, batch) or None)

    def _add(
        self,
        connection: Connection,
        project: str,
        author: str,
        stretches: Sequence[Stretch],
        assignee: str,
        batch: str | None,
    ) -> list[Task]:
        _require_room(connection, project, len(stretches))
        numbers = _numbers(connection, project)
        _require_free(connection, project, stretches)
        now = self._database.now(connection)
        highest = select(func.max(tasks.c.number)).where(tasks.c.project == project)
        last = connection.execute(highest).scalar() or 0
        made = []
        for number, each in enumerate(stretches, last + 1):
            if each.sequence not in numbers:
                raise NotFoundError(
                    f"recordings: expected recordings of {project!r}, got {each.sequence!r}"
                )
            made.append(
                Task(
                    number, each.sequence, each.first, each.last, "open", assignee, "", "",
                    None, None, time_of(now), time_of(now), project,
                )
            )  # fmt: skip
        if made:
            more = {"batch": batch, "created": now, "changed": now}
            rows = [_row(task) | more | {"sequence": numbers[task.sequence]} for task in made]
            connection.execute(insert(tasks), rows)
            connection.execute(insert(task_events), [_event(t, 1, now, author) for t in made])
            for task in made:
                announce(connection, project, _facts(task, author), now)
        return made

    def require_room(self, project: str, count: int) -> None:
        """Raise BadInputError if ``count`` more tasks exceed the project's limit."""
        with self._database.read() as connection:
            _require_room(connection, project, count)

    def made(self, project: str, batch: str | None) -> list[Task] | None:
        """Return the tasks that an earlier call has created, or None."""
        with self._database.read() as connection:
            return _batch(connection, project, batch) or None

    def take(self, project: str, account: str, *, review: bool = False) -> Task | None:
        """Assign the next task to an account atomically and return it, or None.

        The order is: its current task (so a repeated call returns the same task), tasks returned to
        it, tasks reserved for it, free tasks; oldest first.  Recordings of which it has another
        copy are excluded.  ``review``: a task to review, never its own work.  Raises NotFoundError.
        """
        ranks = _to_review(account) if review else _to_label(account)
        state: TaskState = "review" if review else "taken"

        def make(connection: Connection) -> Task | None:
            lock_project(connection, project)
            order = case(*ranks, else_=len(ranks))
            chosen = _chosen(project).where(order < len(ranks), ~seen_elsewhere(account))
            chosen = chosen.order_by(order, tasks.c.number)
            row = connection.execute(chosen.limit(1)).first()
            if row is None:
                return None
            task = _task(row)
            if task.state == state:
                return task
            if review:
                return self._put(connection, replace(task, state=state, reviewer=account), account)
            return self._put(connection, replace(task, state=state, assignee=account), account)

        def find(connection: Connection) -> Task | None:
            row = connection.execute(_chosen(project).where(ranks[0][0]).limit(1)).first()
            return None if row is None else _task(row)

        return write_once(self._database, make, find)

    def change(
        self, project: str, number: int, author: str, decide: Callable[[Task], Task]
    ) -> Task:
        """Replace a task by the result of ``decide`` for it; an error in it changes nothing.

        Raises NotFoundError.
        """

        def make(connection: Connection) -> Task:
            lock_project(connection, project)
            task = _get(connection, project, number)
            wanted.append(decide(task))
            person = wanted[-1].assignee
            there = _chosen(project).where(tasks.c.number == number, seen_elsewhere(person))
            if person not in ("", task.assignee) and connection.execute(there).first():
                raise ConflictError(f"assignee: {person!r} has another copy of this recording")
            return task if wanted[-1] == task else self._put(connection, wanted[-1], author)

        def find(connection: Connection) -> Task | None:
            task = _get(connection, project, number)
            return task if replace(task, changed=wanted[-1].changed) == wanted[-1] else None

        wanted: list[Task] = []
        return write_once(self._database, make, find)

    def _put(self, connection: Connection, task: Task, author: str) -> Task:
        now = self._database.now(connection)
        task = replace(task, changed=time_of(now))
        row = _row(task) | {"changed": now}
        is_task = (tasks.c.project == row.pop("project")) & (tasks.c.number == row.pop("number"))
        connection.execute(update(tasks).where(is_task).values(**row))
        events = task_events.c
        own = (events.project == task.project) & (events.task == task.number)
        last = connection.execute(select(func.max(events.number)).where(own)).scalar() or 0
        connection.execute(insert(task_events), _event(task, last + 1, now, author))
        announce(connection, task.project, _facts(task, author), now)
        return task

    def remove(self, project: str, number: int) -> None:
        """Delete a task with its history; raises NotFoundError."""
        with self._database.write() as connection:
            lock_project(connection, project)
            _get(connection, project, number)
            forget_tasks(connection, (tasks.c.project == project) & (tasks.c.number == number))

    def get(self, project: str, number: int) -> Task:
        """Return one task; raises NotFoundError."""
        with self._database.read() as connection:
            return _get(connection, project, number)

    def entries(self, project: str, wanted: Wanted) -> list[Task]:
        """Return tasks of a project, by number."""
        chosen = _chosen(project).where(tasks.c.number > wanted.after)
        if wanted.state is not None:
            chosen = chosen.where(tasks.c.state == wanted.state)
        if wanted.without:
            chosen = chosen.where(sequences.c.id.not_in(wanted.without))
        if wanted.assignee is not None:
            chosen = chosen.where(tasks.c.assignee == wanted.assignee)
        if wanted.sequence is not None:
            chosen = chosen.where(sequences.c.id == wanted.sequence)
        chosen = chosen.order_by(tasks.c.number).limit(wanted.limit)
        with self._database.read() as connection:
            return [_task(row) for row in connection.execute(chosen)]

    def history(self, project: str, number: int) -> list[TaskEvent]:
        """Return the changes of a task, newest first; raises NotFoundError."""
        events = task_events.c
        chosen = select(task_events).where(events.project == project, events.task == number)
        with self._database.read() as connection:
            _get(connection, project, number)
            rows = connection.execute(chosen.order_by(events.number.desc())).all()
        return [
            TaskEvent(time_of(row.time), row.author, row.state, row.assignee or "", row.note)
            for row in rows
        ]


def _require_room(connection: Connection, project: str, count: int) -> None:
    held = select(func.count()).where(tasks.c.project == project)
    if connection.execute(held).scalar_one() + count > MOST_TASKS:
        raise BadInputError(f"tasks: expected at most {MOST_TASKS:,} in a project")


def _to_label(account: str) -> list[tuple[ColumnElement[bool], int]]:
    state, own = tasks.c.state, tasks.c.assignee == account
    return [
        (own & (state == "taken"), 0),
        (own & (state == "returned"), 1),
        (own & (state == "open"), 2),
        (tasks.c.assignee.is_(None) & (state == "open"), 3),
    ]


def _to_review(account: str) -> list[tuple[ColumnElement[bool], int]]:
    state = tasks.c.state
    return [
        ((tasks.c.reviewer == account) & (state == "review"), 0),
        ((tasks.c.assignee != account) & (state == "done"), 1),
    ]


def _chosen(project: str) -> Select[Any]:
    columns = [column for column in tasks.c if column.name not in ("sequence", "batch")]
    return (
        select(*columns, sequences.c.id.label("sequence"))
        .join(sequences, sequences.c.number == tasks.c.sequence)
        .where(tasks.c.project == project, LIVE)
    )


def _batch(connection: Connection, project: str, batch: str | None) -> list[Task]:
    if batch is None:
        return []
    chosen = _chosen(project).where(tasks.c.batch == batch).order_by(tasks.c.number)
    return [_task(row) for row in connection.execute(chosen)]


def _get(connection: Connection, project: str, number: int) -> Task:
    row = connection.execute(_chosen(project).where(tasks.c.number == number)).first()
    if row is None:
        raise unknown_task(project, number)
    return _task(row)


def unknown_task(project: str, number: int) -> NotFoundError:
    """Return the error for a task that does not exist or is hidden from the caller."""
    return NotFoundError(f"task: expected the number of one of {project!r}, got {number}")


def _numbers(connection: Connection, project: str) -> dict[str, int]:
    chosen = select(sequences.c.id, sequences.c.number).where(project == PROJECT_OF, LIVE)
    return {row.id: row.number for row in connection.execute(chosen)}


def _require_free(connection: Connection, project: str, wanted: Sequence[Stretch]) -> None:
    """Raise ConflictError if two unfinished tasks would share a frame."""
    chosen = _chosen(project).where(tasks.c.state != "accepted")
    there = [Stretch(row.sequence, row.first, row.last) for row in connection.execute(chosen)]
    in_order = sorted([*there, *wanted], key=lambda each: (each.sequence, each.first))
    for one, other in pairwise(in_order):
        if one.sequence == other.sequence and other.first <= one.last:
            raise ConflictError(
                f"frames: {other.first} to {other.last} of {other.sequence!r} have a task that is "
                f"not accepted yet: {one.first} to {one.last}"
            )


def _row(task: Task) -> dict[str, Any]:
    """Return the columns of a task's row except its recording, batch and times."""
    left_out = ("sequence", "created", "changed")
    row = {name: getattr(task, name) for name in Task.__dataclass_fields__ if name not in left_out}
    place = None if task.place is None else json.dumps(task.place)
    people = {"assignee": task.assignee or None, "reviewer": task.reviewer or None}
    return row | people | {"place": place}


def _task(row: Row[Any]) -> Task:
    found = dict(row._mapping)
    place = found["place"]
    return Task(
        **found
        | {"assignee": row.assignee or "", "reviewer": row.reviewer or ""}
        | {"place": None if place is None else tuple(json.loads(place))}
        | {"created": time_of(row.created), "changed": time_of(row.changed)}
    )


def _facts(task: Task, author: str) -> dict[str, Any]:
    names = ("number", "sequence", "first", "last", "state", "assignee", "reviewer", "note")
    return {name: getattr(task, name) for name in names} | {"by": author}


def _event(task: Task, number: int, now: float, author: str) -> dict[str, Any]:
    return {
        "project": task.project,
        "task": task.number,
        "number": number,
        "time": now,
        "author": author,
        "state": task.state,
        "assignee": task.assignee or None,
        "note": task.note,
    }
