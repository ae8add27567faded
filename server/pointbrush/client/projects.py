"""Projects: groups of recordings with their people, tasks, webhooks and snapshots."""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from typing import Any

from pointbrush.client.answers import html_table, read, tuple_of, vector
from pointbrush.client.steps import L, Part, Request, Steps, send, steps
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
        super().__init__(link)
        self.info, self.id = info, info.id
        self._place = f"/projects/{info.id}"

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
        body = ProjectPatch(name, roles, numbers, tuple_of(recordings)).given()
        answer = yield from send(Request("PATCH", self._place, {"json": body}, idempotent=True))
        return read(ProjectInfo, answer.json())

    @steps
    def statistics(self) -> Steps[Statistics]:
        """Return points, objects and hours, by class and person."""
        answer = yield from send(Request("GET", f"{self._place}/statistics", idempotent=True))
        return read(Statistics, answer.json())

    @steps
    def delete(self) -> Steps[None]:
        """Delete the project; raises ConflictError while it has recordings."""
        yield from send(Request("DELETE", self._place))

    @steps
    def import_each(self, server_path: AnyPath, fps: float | None = None) -> Steps[list[Job]]:
        """Import each file and folder in a folder on the server as a recording; return the jobs."""
        body: dict[str, Any] = {"path": str(server_path)} | ({} if fps is None else {"fps": fps})
        answer = yield from send(Request("POST", f"{self._place}/imports", {"json": body}))
        return [read(Job, entry) for entry in answer.json()]

    # ── the queue ────────────────────────────────────────────────────────────────────────

    @steps
    def tasks(
        self, state: TaskState | None = None, person: str | None = None, sequence: str | None = None
    ) -> Steps[list[Task]]:
        """Return the tasks, by number; optionally only of a state, an assignee or a recording."""
        wanted = {"state": state, "person": person, "sequence": sequence}
        query: dict[str, Any] = {n: value for n, value in wanted.items() if value is not None}
        found: list[Task] = []
        while True:
            request = Request("GET", f"{self._place}/tasks", {"params": query}, idempotent=True)
            part = [read(Task, entry) for entry in (yield from send(request)).json()]
            if not part:
                return found
            found += part
            query["after"] = part[-1].number

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
        new = NewTasks(
            tuple_of(recordings), frames, every, assignee, people, truth, str(uuid.uuid4())
        )
        body = new.given()
        request = Request("POST", f"{self._place}/tasks", {"json": body}, idempotent=True)
        return [read(Task, entry) for entry in (yield from send(request)).json()]

    @steps
    def next_task(self, work: Work = "label") -> Steps[Task | None]:
        """Take the next task, or return the caller's current task; None if the queue is empty."""
        request = Request(
            "POST", f"{self._place}/tasks/next", {"json": {"work": work}}, idempotent=True
        )
        found = (yield from send(request)).json()
        return None if found is None else read(Task, found)

    @steps
    def task(self, number: int) -> Steps[Task]:
        """Return a task by its number; raises NotFoundError."""
        request = Request("GET", f"{self._place}/tasks/{number}", idempotent=True)
        return read(Task, (yield from send(request)).json())

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
        body = TaskPatch(state, assignee, note, frame, vector(place)).given()
        request = Request("PATCH", f"{self._place}/tasks/{number}", {"json": body}, idempotent=True)
        return read(Task, (yield from send(request)).json())

    @steps
    def delete_task(self, number: int) -> Steps[None]:
        """Delete a task with its history; the labels stay."""
        yield from send(Request("DELETE", f"{self._place}/tasks/{number}"))

    @steps
    def task_history(self, number: int) -> Steps[list[TaskEvent]]:
        """Return the changes of a task, newest first."""
        request = Request("GET", f"{self._place}/tasks/{number}/history", idempotent=True)
        return [read(TaskEvent, entry) for entry in (yield from send(request)).json()]

    # ── agreement ────────────────────────────────────────────────────────────────────────

    @steps
    def agreement(self, sequence: str) -> Steps[list[CopyAgreement]]:
        """Compare the copies of a recording in pairs; return agreement and differing places."""
        query = {"sequence": sequence}
        place = f"{self._place}/agreement"
        answer = yield from send(Request("GET", place, {"params": query}, idempotent=True))
        return [read(CopyAgreement, entry) for entry in answer.json()]

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
        body = CopyMerge(sequence, take, region, str(uuid.uuid4())).given()
        request = Request("POST", f"{self._place}/merge", {"json": body}, idempotent=True)
        return read(Edit, (yield from send(request)).json())

    @steps
    def scores(self) -> Steps[list[Score]]:
        """Return the scores of each person on tasks with ground truth."""
        answer = yield from send(Request("GET", f"{self._place}/scores", idempotent=True))
        return [read(Score, entry) for entry in answer.json()]

    # ── webhooks ─────────────────────────────────────────────────────────────────────────

    @steps
    def webhooks(self) -> Steps[list[Webhook]]:
        """Return the webhooks of the project."""
        answer = yield from send(Request("GET", f"{self._place}/webhooks", idempotent=True))
        return [read(Webhook, entry) for entry in answer.json()]

    @steps
    def add_webhook(self, url: str, topics: Sequence[Topic] | None = None) -> Steps[SecretWebhook]:
        """Add a webhook for topics (task, labels, job; None: all); return it with its secret."""
        body = NewWebhook(url, tuple_of(topics)).given()
        answer = yield from send(Request("POST", f"{self._place}/webhooks", {"json": body}))
        return read(SecretWebhook, answer.json())

    @steps
    def delete_webhook(self, webhook: str) -> Steps[None]:
        """Delete a webhook with its pending events."""
        yield from send(Request("DELETE", f"{self._place}/webhooks/{webhook}"))

    @steps
    def deliveries(self, webhook: str) -> Steps[list[Delivery]]:
        """Return the latest events of a webhook with their delivery, newest first."""
        place = f"{self._place}/webhooks/{webhook}/deliveries"
        answer = yield from send(Request("GET", place, idempotent=True))
        return [read(Delivery, entry) for entry in answer.json()]

    # ── versions ─────────────────────────────────────────────────────────────────────────

    @steps
    def snapshots(self) -> Steps[list[Snapshot]]:
        """Return the snapshots of the project's labels, newest first."""
        answer = yield from send(Request("GET", f"{self._place}/snapshots", idempotent=True))
        return [read(Snapshot, entry) for entry in answer.json()]

    @steps
    def snapshot(self, name: str) -> Steps[Snapshot]:
        """Save the current labels of the project as a snapshot."""
        request = Request("POST", f"{self._place}/snapshots", {"json": {"name": name}})
        return read(Snapshot, (yield from send(request)).json())

    @steps
    def delete_snapshot(self, snapshot: str) -> Steps[None]:
        """Delete a snapshot; the current labels stay."""
        yield from send(Request("DELETE", f"{self._place}/snapshots/{snapshot}"))

    @steps
    def difference(
        self, snapshot: str, other: str | None = None, sequence: str | None = None
    ) -> Steps[list[Difference]]:
        """Compare a snapshot with another, or with the current labels (None)."""
        given = {"with": other, "sequence": sequence}
        query = {name: value for name, value in given.items() if value is not None}
        place = f"{self._place}/snapshots/{snapshot}/difference"
        answer = yield from send(Request("GET", place, {"params": query}, idempotent=True))
        return [read(Difference, entry) for entry in answer.json()]


class Projects(Part[L]):
    """The projects of a workspace."""

    @steps
    def all(self) -> Steps[list[Project[L]]]:
        """Return the caller's projects, by name."""
        answer = yield from send(Request("GET", "/projects", idempotent=True))
        return [Project(self._link, read(ProjectInfo, entry)) for entry in answer.json()]

    @steps
    def __getitem__(self, project: str) -> Steps[Project[L]]:
        """Return a project by its id; raises NotFoundError."""
        answer = yield from send(Request("GET", f"/projects/{project}", idempotent=True))
        return Project(self._link, read(ProjectInfo, answer.json()))

    @steps
    def create(
        self, name: str, /, *, id: str | None = None, roles: Mapping[str, Role] | None = None,
        categories: Sequence[int] | None = None, recordings: Sequence[str] | None = None,
    ) -> Steps[Project[L]]:  # fmt: skip
        """Add a project and return it; ``categories`` None: all.  Raises ConflictError."""
        new = NewProject(
            name=name, id=id, roles=roles, categories=tuple_of(categories),
            recordings=tuple_of(recordings),
        )  # fmt: skip
        answer = yield from send(Request("POST", "/projects", {"json": new.given()}))
        return Project(self._link, read(ProjectInfo, answer.json()))
