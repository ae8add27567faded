"""Projects: groups of recordings with their people, tasks, webhooks and snapshots."""

from __future__ import annotations

import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal

from pointbrush.client.steps import L, Part, Request, Steps, send, steps
from pointbrush.client.uploads import AnyPath
from pointbrush.client.values import Edit, Job, Vector, html_table, read


@dataclass(frozen=True, slots=True)
class Task:
    """A task: label frames ``first`` to ``last``, both included, of recording ``sequence``.

    ``state``: open, taken, done, review, accepted, returned.  ``note`` is pinned to ``place`` in
    ``frame``, source coordinates, metres.
    """

    number: int
    sequence: str
    first: int
    last: int
    state: str
    assignee: str
    reviewer: str
    note: str
    frame: int | None
    place: Vector | None
    created: datetime
    changed: datetime


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A version of a project's labels: the revision of each recording at its time."""

    id: str
    name: str
    created: datetime
    author: str
    recordings: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class LabelDifference:
    """A label that differs: it ``came``, ``went`` or was ``changed``."""

    label: int
    name: str
    kind: str


@dataclass(frozen=True, slots=True)
class FrameDifference:
    """Points of a frame that gained, lost or changed their label; ids of labels in it."""

    frame: int
    came: int
    went: int
    changed: int
    objects_came: tuple[int, ...]
    objects_went: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Difference:
    """Difference of a recording's labels between two versions."""

    sequence: str
    labels: tuple[LabelDifference, ...]
    frames: tuple[FrameDifference, ...]


@dataclass(frozen=True, slots=True)
class ProjectInfo:
    """Facts of a project; ``role`` of the caller; number of ``tasks`` by state, and by person."""

    id: str
    name: str
    created: datetime
    role: str
    roles: Mapping[str, str]
    categories: tuple[int, ...] | None
    recordings: tuple[str, ...]
    tasks: Mapping[str, int]
    people: Mapping[str, Mapping[str, int]]


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
    def change(self, /, **fields: Any) -> Steps[ProjectInfo]:
        """Change the name, roles or categories, or add ``recordings``; return the new facts.

        ``categories`` None: all.
        """
        answer = yield from send(Request("PATCH", self._place, {"json": fields}, again=True))
        return read(ProjectInfo, answer.json())

    @steps
    def statistics(self) -> Steps[dict[str, Any]]:
        """Return points, objects and hours, by class and person."""
        answer = yield from send(Request("GET", f"{self._place}/statistics", again=True))
        found: dict[str, Any] = answer.json()
        return found

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
        self, state: str | None = None, person: str | None = None, sequence: str | None = None
    ) -> Steps[list[Task]]:
        """Return the tasks, by number; optionally only of a state, an assignee or a recording."""
        wanted = {"state": state, "person": person, "sequence": sequence}
        query: dict[str, Any] = {n: value for n, value in wanted.items() if value is not None}
        found: list[Task] = []
        while True:
            request = Request("GET", f"{self._place}/tasks", {"params": query}, again=True)
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
        given = {"recordings": recordings, "frames": frames, "every": every}
        body: dict[str, Any] = {n: value for n, value in given.items() if value is not None}
        body |= {"assignee": assignee, "people": people, "truth": truth, "id": str(uuid.uuid4())}
        request = Request("POST", f"{self._place}/tasks", {"json": body}, again=True)
        return [read(Task, entry) for entry in (yield from send(request)).json()]

    @steps
    def next_task(self, work: Literal["label", "review"] = "label") -> Steps[Task | None]:
        """Take the next task, or return the caller's current task; None if the queue is empty."""
        request = Request("POST", f"{self._place}/tasks/next", {"json": {"work": work}}, again=True)
        found = (yield from send(request)).json()
        return None if found is None else read(Task, found)

    @steps
    def task(self, number: int) -> Steps[Task]:
        """Return a task by its number; raises NotFoundError."""
        request = Request("GET", f"{self._place}/tasks/{number}", again=True)
        return read(Task, (yield from send(request)).json())

    @steps
    def put_task(
        self,
        number: int,
        *,
        state: str | None = None,
        assignee: str | None = None,
        note: str | None = None,
        frame: int | None = None,
        place: Sequence[float] | None = None,
    ) -> Steps[Task]:
        """Change the given fields of a task and return it.

        Raises ForbiddenError, ConflictError, BadInputError.
        """
        given = {
            "state": state,
            "assignee": assignee,
            "note": note,
            "frame": frame,
            "place": None if place is None else [float(value) for value in place],
        }
        body = {name: value for name, value in given.items() if value is not None}
        request = Request("PATCH", f"{self._place}/tasks/{number}", {"json": body}, again=True)
        return read(Task, (yield from send(request)).json())

    @steps
    def delete_task(self, number: int) -> Steps[None]:
        """Delete a task with its history; the labels stay."""
        yield from send(Request("DELETE", f"{self._place}/tasks/{number}"))

    @steps
    def task_history(self, number: int) -> Steps[list[dict[str, Any]]]:
        """Return the changes of a task, newest first."""
        request = Request("GET", f"{self._place}/tasks/{number}/history", again=True)
        found: list[dict[str, Any]] = (yield from send(request)).json()
        return found

    # ── agreement ────────────────────────────────────────────────────────────────────────

    @steps
    def agreement(self, sequence: str) -> Steps[list[dict[str, Any]]]:
        """Compare the copies of a recording in pairs; return agreement and differing places."""
        query = {"sequence": sequence}
        place = f"{self._place}/agreement"
        answer = yield from send(Request("GET", place, {"params": query}, again=True))
        found: list[dict[str, Any]] = answer.json()
        return found

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
        body: dict[str, Any] = {"sequence": sequence, "take": take, "id": str(uuid.uuid4())}
        if labels is not None:
            body["region"] = {"labels": {n: [*e] for n, e in labels.items()}, "frame": frame}
        request = Request("POST", f"{self._place}/merge", {"json": body}, again=True)
        return read(Edit, (yield from send(request)).json())

    @steps
    def scores(self) -> Steps[list[dict[str, Any]]]:
        """Return the scores of each person on tasks with ground truth."""
        answer = yield from send(Request("GET", f"{self._place}/scores", again=True))
        found: list[dict[str, Any]] = answer.json()
        return found

    # ── webhooks ─────────────────────────────────────────────────────────────────────────

    @steps
    def webhooks(self) -> Steps[list[dict[str, Any]]]:
        """Return the webhooks of the project."""
        answer = yield from send(Request("GET", f"{self._place}/webhooks", again=True))
        found: list[dict[str, Any]] = answer.json()
        return found

    @steps
    def add_webhook(self, url: str, topics: Sequence[str] | None = None) -> Steps[dict[str, Any]]:
        """Add a webhook for topics (task, labels, job; None: all); return its id and secret."""
        body = {"url": url} if topics is None else {"url": url, "topics": list(topics)}
        answer = yield from send(Request("POST", f"{self._place}/webhooks", {"json": body}))
        made: dict[str, Any] = answer.json()
        return made

    @steps
    def delete_webhook(self, webhook: str) -> Steps[None]:
        """Delete a webhook with its pending events."""
        yield from send(Request("DELETE", f"{self._place}/webhooks/{webhook}"))

    @steps
    def deliveries(self, webhook: str) -> Steps[list[dict[str, Any]]]:
        """Return the latest events of a webhook with their delivery, newest first."""
        place = f"{self._place}/webhooks/{webhook}/deliveries"
        found: list[dict[str, Any]] = (yield from send(Request("GET", place, again=True))).json()
        return found

    # ── versions ─────────────────────────────────────────────────────────────────────────

    @steps
    def snapshots(self) -> Steps[list[Snapshot]]:
        """Return the snapshots of the project's labels, newest first."""
        answer = yield from send(Request("GET", f"{self._place}/snapshots", again=True))
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
        answer = yield from send(Request("GET", place, {"params": query}, again=True))
        return [read(Difference, entry) for entry in answer.json()]


class Projects(Part[L]):
    """The projects of a workspace."""

    @steps
    def all(self) -> Steps[list[Project[L]]]:
        """Return the caller's projects, by name."""
        answer = yield from send(Request("GET", "/projects", again=True))
        return [Project(self._link, read(ProjectInfo, entry)) for entry in answer.json()]

    @steps
    def __getitem__(self, project: str) -> Steps[Project[L]]:
        """Return a project by its id; raises NotFoundError."""
        answer = yield from send(Request("GET", f"/projects/{project}", again=True))
        return Project(self._link, read(ProjectInfo, answer.json()))

    @steps
    def create(self, name: str, /, **fields: Any) -> Steps[Project[L]]:
        """Add a project; ``fields``: id, roles, categories, recordings.  Raises ConflictError."""
        answer = yield from send(Request("POST", "/projects", {"json": {"name": name, **fields}}))
        return Project(self._link, read(ProjectInfo, answer.json()))
