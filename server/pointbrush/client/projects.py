"""Projects: groups of recordings with their people, tasks, webhooks and snapshots."""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from typing import Any

from pointbrush.client.answers import html_table, read, tuple_of, vector
from pointbrush.client.steps import L, Part, Steps, steps
from pointbrush.client.uploads import AnyPath
from pointbrush.values.base import UNSET
from pointbrush.values.edits import Edit
from pointbrush.values.jobs import Job
from pointbrush.values.kinds import Role, TaskState
from pointbrush.values.team.projects import NewProject, ProjectInfo, ProjectPatch, Statistics
from pointbrush.values.team.snapshots import Difference, Snapshot
from pointbrush.values.team.tasks import (
    CopyAgreement,
    CopyMerge,
    NewTasks,
    Region,
    Score,
    Task,
    TaskEvent,
    TaskPatch,
    Work,
)
from pointbrush.values.team.webhooks import Delivery, NewWebhook, SecretWebhook, Topic, Webhook


class Project(Part[L]):
    """A project; ``info``: its facts as of the call that returned it."""

    def __init__(self, link: L, info: ProjectInfo) -> None:
        super().__init__(link, f"/projects/{info.id}")
        self.info, self.id = info, info.id

    def __repr__(self) -> str:
        return f"Project({self.id!r}, {len(self.info.recordings)} recordings)"

    def _repr_html_(self) -> str:
        """Return a table of the project for a notebook."""
        known = self.info
        facts = {
            "id": known.id,
            "recordings": ", ".join(known.recordings),
            "people": ", ".join(f"{person} ({role})" for person, role in known.roles.items()),
            "tasks": ", ".join(f"{count} {state}" for state, count in known.tasks.items()),
        }
        return html_table(known.name, facts)

    @steps
    def change(
        self, /, *, name: str | None = None, roles: Mapping[str, Role] | None = None,
        categories: Sequence[int] | None = UNSET, recordings: Sequence[str] | None = None,
    ) -> Steps[ProjectInfo]:  # fmt: skip
        """Change the given values, or add ``recordings``; return the new facts.

        ``categories``: numbers of the selected classes; None: all classes.
        """
        numbers = categories if categories is UNSET else tuple_of(categories)
        body = ProjectPatch(name, roles, numbers, tuple_of(recordings))
        return self._change(ProjectInfo, "PATCH", "", body)

    @steps
    def statistics(self) -> Steps[Statistics]:
        """Return points, objects and hours, by class and person."""
        return self._get(Statistics, "/statistics")

    @steps
    def delete(self) -> Steps[None]:
        """Delete the project; raises ConflictError while it has recordings."""
        yield from self._call("DELETE")

    @steps
    def import_each(self, server_path: AnyPath, fps: float | None = None) -> Steps[list[Job]]:
        """Import each file and folder in a folder on the server as a recording; return the jobs."""
        body: dict[str, Any] = {"path": str(server_path)} | ({} if fps is None else {"fps": fps})
        return self._change(list[Job], "POST", "/imports", body, idempotent=False)

    # ── the queue ────────────────────────────────────────────────────────────────────────

    @steps
    def tasks(
        self, state: TaskState | None = None, person: str | None = None, sequence: str | None = None
    ) -> Steps[list[Task]]:
        """Return the tasks, by number; optionally only of a state, an assignee or a recording."""
        query: dict[str, Any] = {"state": state, "person": person, "sequence": sequence}
        found: list[Task] = []
        while part := (yield from self._get(list[Task], "/tasks", **query)):
            found += part
            query["after"] = part[-1].number
        return found

    @steps
    def add_tasks(
        self,
        recordings: Sequence[str] | None = None,
        *,
        frames: str | None = None,
        every: int | None = None,
        assignee: str = "",
        people: int = 1,
        truth: bool = False,
    ) -> Steps[list[Task]]:
        """Add a task for each recording (None: all), or for each ``every`` frames of ``frames``.

        ``people``: number of annotators of the same frames, each with their own copy.  ``truth``:
        the current labels are ground truth, and hidden from the annotators.  Raises ConflictError
        for frames with a task that is not accepted yet.
        """
        body = NewTasks(
            tuple_of(recordings), frames, every, assignee, people, truth, str(uuid.uuid4())
        )
        return self._change(list[Task], "POST", "/tasks", body)

    @steps
    def next_task(self, work: Work = "label") -> Steps[Task | None]:
        """Take the next task, or return the caller's current task; None if the queue is empty."""
        answer = yield from self._call("POST", "/tasks/next", json={"work": work}, idempotent=True)
        found = answer.json()
        return None if found is None else read(Task, found)

    @steps
    def task(self, number: int) -> Steps[Task]:
        """Return a task by its number; raises NotFoundError."""
        return self._get(Task, f"/tasks/{number}")

    @steps
    def put_task(
        self,
        number: int,
        *,
        state: TaskState | None = None,
        assignee: str | None = None,
        note: str | None = None,
        frame: int | None = None,
        place: Sequence[float] | None = None,
    ) -> Steps[Task]:
        """Change the given fields of a task and return it.

        Raises ForbiddenError, ConflictError, BadInputError.
        """
        body = TaskPatch(note, vector(place), assignee, state, frame)
        return self._change(Task, "PATCH", f"/tasks/{number}", body)

    @steps
    def delete_task(self, number: int) -> Steps[None]:
        """Delete a task with its history; the labels stay."""
        yield from self._call("DELETE", f"/tasks/{number}")

    @steps
    def task_history(self, number: int) -> Steps[list[TaskEvent]]:
        """Return the changes of a task, newest first."""
        return self._get(list[TaskEvent], f"/tasks/{number}/history")

    # ── agreement ────────────────────────────────────────────────────────────────────────

    @steps
    def agreement(self, sequence: str) -> Steps[list[CopyAgreement]]:
        """Compare the copies of a recording in pairs; return agreement and differing places."""
        return self._get(list[CopyAgreement], "/agreement", sequence=sequence)

    @steps
    def merge(
        self,
        sequence: str,
        take: str = "majority",
        labels: Mapping[str, Sequence[int]] | None = None,
        frame: int | None = None,
    ) -> Steps[Edit]:
        """Write the majority's labels, or the labels of one copy by its id, into the recording.

        ``labels``: ids of labels by copy; only their points in ``frame`` are written.
        """
        region = None
        if labels is not None:
            region = Region({name: tuple(each) for name, each in labels.items()}, frame)
        body = CopyMerge(sequence, take, region, str(uuid.uuid4()))
        return self._change(Edit, "POST", "/merge", body)

    @steps
    def scores(self) -> Steps[list[Score]]:
        """Return the scores of each person on tasks with ground truth."""
        return self._get(list[Score], "/scores")

    # ── webhooks ─────────────────────────────────────────────────────────────────────────

    @steps
    def webhooks(self) -> Steps[list[Webhook]]:
        """Return the webhooks of the project."""
        return self._get(list[Webhook], "/webhooks")

    @steps
    def add_webhook(self, url: str, topics: Sequence[Topic] | None = None) -> Steps[SecretWebhook]:
        """Add a webhook for topics (task, labels, job; None: all); return it with its secret."""
        body = NewWebhook(url, tuple_of(topics))
        return self._change(SecretWebhook, "POST", "/webhooks", body, idempotent=False)

    @steps
    def delete_webhook(self, webhook: str) -> Steps[None]:
        """Delete a webhook with its pending events."""
        yield from self._call("DELETE", f"/webhooks/{webhook}")

    @steps
    def deliveries(self, webhook: str) -> Steps[list[Delivery]]:
        """Return the latest events of a webhook with their delivery, newest first."""
        return self._get(list[Delivery], f"/webhooks/{webhook}/deliveries")

    # ── versions ─────────────────────────────────────────────────────────────────────────

    @steps
    def snapshots(self) -> Steps[list[Snapshot]]:
        """Return the snapshots of the project's labels, newest first."""
        return self._get(list[Snapshot], "/snapshots")

    @steps
    def snapshot(self, name: str) -> Steps[Snapshot]:
        """Save the current labels of the project as a snapshot."""
        return self._change(Snapshot, "POST", "/snapshots", {"name": name}, idempotent=False)

    @steps
    def delete_snapshot(self, snapshot: str) -> Steps[None]:
        """Delete a snapshot; the current labels stay."""
        yield from self._call("DELETE", f"/snapshots/{snapshot}")

    @steps
    def difference(
        self, snapshot: str, other: str | None = None, sequence: str | None = None
    ) -> Steps[list[Difference]]:
        """Compare a snapshot with another, or with the current labels (None)."""
        query = {"with": other, "sequence": sequence}
        return self._get(list[Difference], f"/snapshots/{snapshot}/difference", **query)


class Projects(Part[L]):
    """The projects of a workspace."""

    @steps
    def all(self) -> Steps[list[Project[L]]]:
        """Return the caller's projects, by name."""
        found = yield from self._get(list[ProjectInfo], "/projects")
        return [Project(self._link, each) for each in found]

    @steps
    def __getitem__(self, project: str) -> Steps[Project[L]]:
        """Return a project by its id; raises NotFoundError."""
        return Project(self._link, (yield from self._get(ProjectInfo, f"/projects/{project}")))

    @steps
    def create(
        self, name: str, /, *, id: str | None = None, roles: Mapping[str, Role] | None = None,
        categories: Sequence[int] | None = None, recordings: Sequence[str] | None = None,
    ) -> Steps[Project[L]]:  # fmt: skip
        """Add a project and return it; ``categories`` None: all.  Raises ConflictError."""
        body = NewProject(
            name=name, id=id, roles=roles, categories=tuple_of(categories),
            recordings=tuple_of(recordings),
        )  # fmt: skip
        made = yield from self._change(ProjectInfo, "POST", "/projects", body, idempotent=False)
        return Project(self._link, made)
