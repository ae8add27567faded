"""The service for projects of a workspace, with their progress."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

from pointbrush.accounts.roles import Role, includes
from pointbrush.teamwork.access import COMPARES, Sight
from pointbrush.teamwork.projects import Project
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.summaries import Counts, Effort
from pointbrush.values.kinds import TaskState, time_of
from pointbrush.values.team.projects import ProjectInfo, ProjectPatch, Statistics
from pointbrush.work.events import Event, SequencesChanged
from pointbrush.work.reviewing.report.gather import MACHINE, STROKES, EffortOptions
from pointbrush.work.trash import ids_for


class Projects:
    """The projects of a workspace; thread-safe."""

    def __init__(self, store: WorkspaceStore, publish: Callable[[Event], None]) -> None:
        self._store, self._publish = store, publish

    def all(self, account: str, role: Role) -> list[ProjectInfo]:
        """Return the visible projects of an account, by name."""
        overviews, visible = [], cache(partial(self._visible, account))
        for project in self._store.team.projects.all():
            own = project.role_of(account, role)
            if own is not None:
                overviews.append(self._overview(project, own, *visible(includes(own, COMPARES))))
        return overviews

    def get(self, project: str, account: str, role: Role) -> ProjectInfo:
        """Return a project for an account with ``role`` in it; raises NotFoundError."""
        visible = self._visible(account, includes(role, COMPARES))
        return self._overview(self._store.team.projects.get(project), role, *visible)

    def _sight(self, account: str, compares: bool) -> Sight:
        return Sight() if compares else self._store.team.access.sight(account)

    def _visible(self, account: str, compares: bool) -> tuple[Sight, Counts]:
        sight = self._sight(account, compares)
        return sight, self._store.team.summaries.tasks(sight.hidden)

    def statistics(self, project: str, account: str, role: Role) -> Statistics:
        """Return points, objects and times of a project by class and person, with names of people.

        Recordings that are hidden from the account, such as ground truth, are excluded.
        """
        self._store.team.projects.get(project)
        options = EffortOptions()
        effort = Effort(options.idle, options.first, MACHINE, STROKES)
        sight = self._sight(account, includes(role, COMPARES))
        figures = self._store.team.summaries.figures(project, effort, sight.hidden)
        name = self._store.accounts.name
        people = [replace(each, name=name(each.name)) for each in figures.people]
        return replace(figures, people=tuple(people))

    def create(
        self, change: ProjectPatch, project: str | None, account: str, role: Role
    ) -> ProjectInfo:
        """Create a project, by default with an id derived from its name; raises ConflictError."""
        there = {each.id for each in self._store.team.projects.all()}
        wanted = project or next(name for name in ids_for(change.name or "") if name not in there)
        made = self._store.team.projects.create(wanted, change)
        self._changed(change)
        return self.get(made.id, account, role)

    def change(self, project: str, change: ProjectPatch, account: str, role: Role) -> ProjectInfo:
        """Apply a change to a project; raises the errors of the store."""
        self._store.team.projects.change(project, change)
        self._changed(change)
        return self.get(project, account, role)

    def remove(self, project: str) -> None:
        """Delete a project without recordings."""
        self._store.team.projects.remove(project)
        self._store.team.access.forget()

    def _changed(self, change: ProjectPatch) -> None:
        self._store.team.access.forget()
        for sequence in change.recordings or ():
            self._publish(SequencesChanged(sequence))

    def _overview(self, project: Project, role: Role, sight: Sight, counts: Counts) -> ProjectInfo:
        own = {copy for copy, home in sight.copies.items() if home == project.id}
        shown = (own | {*project.recordings}) - sight.hidden
        states: Counter[TaskState] = Counter()
        people: dict[str, dict[TaskState, int]] = {}
        for (account, state), count in sorted(counts.get(project.id, {}).items()):
            states[state] += count
            name = self._store.accounts.name(account) if account else ""
            people.setdefault(name, {})[state] = count
        return ProjectInfo.of(
            project, created=time_of(project.created), role=role, recordings=tuple(sorted(shown)),
            tasks=dict(states), people=people,
        )  # fmt: skip
