"""The service for the queue of a project: creation and steps of tasks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from pointbrush.accounts.accounts import require_name
from pointbrush.accounts.roles import includes
from pointbrush.errors import BadInputError
from pointbrush.sequences import Sequence as Recording
from pointbrush.teamwork.access import COMPARES
from pointbrush.teamwork.copies import CopyKind
from pointbrush.teamwork.rules import Person, fulfilled
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.tasks import Stretch, Task, Wanted, unknown_task
from pointbrush.values.team.tasks import NewTasks, TaskEvent, TaskPatch
from pointbrush.work.exporting import parse_frames

MOST_PEOPLE = 9
"""Limit of people that label the same frames."""
MOST_TASKS = 10_000
"""Limit of tasks created by one call."""

__all__ = ["NewTasks", "Queue", "TaskPatch"]


class Queue:
    """The tasks of all projects; thread-safe.

    Every method raises NotFoundError for an unknown project or task.
    """

    def __init__(
        self,
        store: WorkspaceStore,
        recording: Callable[[str], Recording],
        copy: Callable[[str, str, range, CopyKind], str],
    ) -> None:
        """``copy``: copies frames of a recording within a project, for one person."""
        self._store, self._recording, self._copy = store, recording, copy

    def add(self, project: str, author: str, new: NewTasks) -> list[Task]:
        """Create tasks; raises ConflictError for frames with a task that is not accepted."""
        if new.every is not None and new.every < 1:
            raise BadInputError(f"every: expected 1 frame or more, got {new.every}")
        if new.assignee:
            require_name(new.assignee)
        if not 1 <= new.people <= MOST_PEOPLE or (new.truth and new.people > 1):
            raise BadInputError(
                f"people: expected 1 to {MOST_PEOPLE}, and 1 with known truth, got {new.people}"
            )
        if (made := self._store.team.tasks.made(project, new.id)) is not None:
            return [self._named(task) for task in made]  # without new copies
        chosen = self._store.team.projects.get(project).recordings
        wanted = {
            sequence: parse_frames(new.frames, len(self._recording(sequence)))
            for sequence in (chosen if new.recordings is None else new.recordings)
        }
        starts = {name: frames[:: new.every or len(frames)] for name, frames in wanted.items()}
        self._require_room(project, new.people * sum(map(len, starts.values())))
        stretches = [
            Stretch(of_one, first, min(first + starts[sequence].step, frames.stop) - 1)
            for sequence, frames in wanted.items()
            for of_one in self._copies(project, sequence, frames, new)
            for first in starts[sequence]
        ]
        made = self._store.team.tasks.add(
            project, author, stretches, assignee=new.assignee, batch=new.id
        )
        return [self._named(task) for task in made]

    def _require_room(self, project: str, count: int) -> None:
        """Raise BadInputError for too many tasks, before recordings are copied."""
        if count > MOST_TASKS:
            raise BadInputError(f"tasks: expected at most {MOST_TASKS:,} of a call, got {count:,}")
        self._store.team.tasks.require_room(project, count)

    def _copies(self, project: str, sequence: str, frames: range, new: NewTasks) -> list[str]:
        if new.truth:
            return [self._copy(sequence, project, frames, "truth")]
        if new.people == 1:
            return [sequence]
        return [self._copy(sequence, project, frames, "agreement") for _ in range(new.people)]

    def next(self, project: str, account: str, *, review: bool = False) -> Task | None:
        """Return the next task to label or review, or None; a repeated call returns the same."""
        task = self._store.team.tasks.take(project, account, review=review)
        self._store.team.access.forget()  # a copy replaces its recording for the account
        return None if task is None else self._named(task)

    def change(self, project: str, number: int, who: Person, wish: TaskPatch) -> Task:
        """Change the state, assignee or note of a task; see ``rules.fulfilled``."""
        if wish.assignee:
            require_name(wish.assignee)
        self.get(project, number, who)
        decide = partial(fulfilled, wish=wish, who=who)
        task = self._store.team.tasks.change(project, number, who.account, decide)
        self._store.team.access.forget()
        return self._named(task)

    def remove(self, project: str, number: int) -> None:
        """Delete a task with its history; labels are kept."""
        self._store.team.tasks.remove(project, number)

    def get(self, project: str, number: int, who: Person) -> Task:
        """Return a task, with names of people."""
        task = self._store.team.tasks.get(project, number)
        if task.sequence in self._hidden(who):
            raise unknown_task(project, number)
        return self._named(task)

    def _hidden(self, who: Person) -> frozenset[str]:
        """Return the recordings with tasks hidden from ``who``, such as copies of others."""
        if includes(who.role, COMPARES):
            return frozenset()
        return self._store.team.access.sight(who.account).hidden

    def entries(self, project: str, wanted: Wanted, who: Person) -> list[Task]:
        """Return tasks by number, with names of people."""
        self._store.team.projects.get(project)
        wanted = replace(wanted, without=self._hidden(who))
        return [self._named(task) for task in self._store.team.tasks.entries(project, wanted)]

    def history(self, project: str, number: int, who: Person) -> list[TaskEvent]:
        """Return the changes of a task, newest first, with names of people."""
        self.get(project, number, who)
        name = self._name
        return [
            replace(each, by=name(each.by), assignee=name(each.assignee))
            for each in self._store.team.tasks.history(project, number)
        ]

    def _name(self, account: str) -> str:
        return self._store.accounts.name(account) if account else ""

    def _named(self, task: Task) -> Task:
        assignee, reviewer = self._name(task.assignee), self._name(task.reviewer)
        return replace(task, assignee=assignee, reviewer=reviewer)
