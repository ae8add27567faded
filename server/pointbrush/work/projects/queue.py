"""The queue of a project, for the fronts: tasks made, taken, handed in, accepted, returned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from pointbrush.errors import BadInputError
from pointbrush.labels import LabelStore
from pointbrush.labels.access import COMPARES
from pointbrush.labels.accounts import require_name
from pointbrush.labels.copies import CopyKind
from pointbrush.labels.tasks import Stretch, Task, TaskEvent, Wanted, unknown_task
from pointbrush.roles import includes
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.exporting import parse_frames
from pointbrush.work.projects.rules import Person, Wish, fulfilled

MOST_PEOPLE = 9
"""People who label the same frames."""
MOST_TASKS = 10_000
"""Tasks that one call makes."""

__all__ = ["NewTasks", "Queue", "Wish"]


@dataclass(frozen=True, slots=True)
class NewTasks:
    """Tasks to be made.

    ``recordings``  their ids; None: all of the project.
    ``frames``      "I:J" of each; None: all.
    ``every``       frames of a task; None: a task has all.
    ``assignee``    account that it is meant for, or "".
    ``people``      who label the same, each a copy of their own; ``truth``: one copy without
                    labels, to be compared with those that are known.
    ``id``          of the call: repeated, it makes no others.
    """

    recordings: Sequence[str] | None = None
    frames: str | None = None
    every: int | None = None
    assignee: str = ""
    people: int = 1
    truth: bool = False
    id: str | None = None


class Queue:
    """The tasks of all projects; thread-safe.

    Every method raises NotFoundError for an unknown project or task.
    """

    def __init__(
        self,
        store: LabelStore,
        recording: Callable[[str], Recording],
        copy: Callable[[str, str, range, CopyKind], str],
    ) -> None:
        """``copy``: makes a copy of frames of a recording in a project, for one person."""
        self._store, self._recording, self._copy = store, recording, copy

    def add(self, project: str, author: str, new: NewTasks) -> list[Task]:
        """Make tasks; raises ConflictError for frames that have one which is not accepted yet."""
        if new.every is not None and new.every < 1:
            raise BadInputError(f"every: expected 1 frame or more, got {new.every}")
        if new.assignee:
            require_name(new.assignee)
        if not 1 <= new.people <= MOST_PEOPLE or (new.truth and new.people > 1):
            raise BadInputError(
                f"people: expected 1 to {MOST_PEOPLE}, and 1 with known truth, got {new.people}"
            )
        if (made := self._store.team.tasks.made(project, new.id)) is not None:
            return [self._named(task) for task in made]  # and no other copies
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
        """Raise BadInputError for too many tasks, before copies are made for them."""
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
        """Take the next task to label, or to look at, if any; asked twice it is the same one."""
        task = self._store.team.tasks.take(project, account, review=review)
        self._store.team.access.forget()  # a copy takes the place of its recording
        return None if task is None else self._named(task)

    def change(self, project: str, number: int, who: Person, wish: Wish) -> Task:
        """Give a task another state, assignee or note; see ``rules.fulfilled``."""
        if wish.assignee:
            require_name(wish.assignee)
        self.get(project, number, who)
        decide = partial(fulfilled, wish=wish, who=who)
        task = self._store.team.tasks.change(project, number, who.account, decide)
        self._store.team.access.forget()
        return self._named(task)

    def remove(self, project: str, number: int) -> None:
        """Remove a task with its history; labels stay."""
        self._store.team.tasks.remove(project, number)

    def get(self, project: str, number: int, who: Person) -> Task:
        """Return one task, people by their names."""
        task = self._store.team.tasks.get(project, number)
        if task.sequence in self._hidden(who):
            raise unknown_task(project, number)
        return self._named(task)

    def _hidden(self, who: Person) -> frozenset[str]:
        """Return the recordings whose tasks are not for ``who``: others' copies, for one."""
        if includes(who.role, COMPARES):
            return frozenset()
        return self._store.team.access.sight(who.account).hidden

    def entries(self, project: str, wanted: Wanted, who: Person) -> list[Task]:
        """Return tasks by number, people by their names."""
        self._store.team.projects.get(project)
        wanted = replace(wanted, without=self._hidden(who))
        return [self._named(task) for task in self._store.team.tasks.entries(project, wanted)]

    def history(self, project: str, number: int, who: Person) -> list[TaskEvent]:
        """Return the changes of a task, the newest first, people by their names."""
        self.get(project, number, who)
        name = self._name
        return [
            replace(each, author=name(each.author), assignee=name(each.assignee))
            for each in self._store.team.tasks.history(project, number)
        ]

    def _name(self, account: str) -> str:
        return self._store.accounts.name(account) if account else ""

    def _named(self, task: Task) -> Task:
        assignee, reviewer = self._name(task.assignee), self._name(task.reviewer)
        return replace(task, assignee=assignee, reviewer=reviewer)
