"""Projects: recordings in groups, with people's roles and a selection of the categories."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated

from fastapi import Response
from pydantic import Field

from pointbrush.accounts.roles import Role
from pointbrush.teamwork.projects import Change
from pointbrush.teamwork.tasks import TaskState
from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import SEQUENCE_ID, ProjectId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import VISIBLE, Body, Name, Out
from pointbrush.work.projects.service import Overview

router = resource("projects")
Account = Annotated[str, Field(min_length=1, max_length=128, pattern=f"^{VISIBLE}+$")]
# Pydantic describes the pattern of keys without saying that there are no others.
Roles = Annotated[
    dict[Account, Role],
    Field(max_length=10_000, json_schema_extra={"additionalProperties": False}),
]
Recordings = Annotated[
    list[Annotated[str, Field(pattern=SEQUENCE_ID, max_length=64)]], Field(max_length=100_000)
]
Categories = Annotated[
    list[Annotated[int, Field(ge=1, le=65535)]],
    Field(max_length=65535, description="numbers of the taxonomy"),
]


class ProjectBody(Body):
    """A new project; ``roles`` by account; without ``roles``, the roles of the workspace apply."""

    name: Name
    id: Annotated[str, Field(pattern=SEQUENCE_ID, max_length=64)] | None = None
    roles: Roles | None = None
    categories: Categories | None = None
    recordings: Recordings | None = None


class ProjectPatch(Body):
    """Values to set; missing fields do not change.

    ``recordings`` move from their former projects; ``categories`` null: all categories.
    """

    name: Name | None = None
    roles: Roles | None = None
    categories: Categories | None = None
    recordings: Recordings | None = None


class ProjectOut(Out):
    """A project: ``role`` is the caller's; ``tasks`` in each state, by the person in ``people``."""

    id: str
    name: str
    created: datetime
    role: Role
    roles: dict[str, Role]
    categories: list[int] | None
    recordings: list[str]
    tasks: dict[TaskState, int]
    people: dict[str, dict[TaskState, int]]

    @classmethod
    def seen(cls, found: Overview) -> ProjectOut:
        """Return the answer for a project of the workspace."""
        values = {name: getattr(found.project, name) for name in _OF_PROJECT}
        counts = {"role": found.role, "tasks": found.tasks, "people": found.people}
        return cls.model_validate({**values, **counts, "recordings": [*found.project.recordings]})


_OF_PROJECT = ("id", "name", "created", "roles", "categories")


@router.get("/projects")
def list_projects(workspace: Ws, who: Caller) -> list[ProjectOut]:
    """List the projects that the caller may open, by name."""
    return [ProjectOut.seen(each) for each in workspace.projects.all(who.author, who.role)]


@router.post("/projects", status_code=201, responses=responses(404, 409, 413))
def create_project(body: ProjectBody, response: Response, workspace: Ws, who: Caller) -> ProjectOut:
    """Create a project; its id derives from its name unless one is given."""
    change = Change(body.name, body.categories, roles=body.roles, recordings=body.recordings)
    made = ProjectOut.seen(workspace.projects.create(change, body.id, who.author, who.role))
    response.headers["Location"] = f"/api/v1/projects/{made.id}"
    return made


@router.get("/projects/{p}", responses=responses(404))
def get_project(p: ProjectId, workspace: Ws, who: Caller) -> ProjectOut:
    """Return a project."""
    return ProjectOut.seen(workspace.projects.get(p, who.author, who.role))


class ClassFiguresOut(Out):
    """Points of a class, and its objects: the labels with points."""

    name: str
    points: int
    objects: int
    hours: Annotated[float, Field(description="by the class's share of painted points")]


class PersonFiguresOut(Out):
    """Hours and number of a person's edits, and the points of their strokes."""

    name: str
    hours: float
    edits: int
    points: int


class StatisticsOut(Out):
    """Figures of a project; classes are sorted by points, people by hours, the largest first."""

    recordings: int
    labelled_frames: int
    points: int
    objects: int
    hours: float
    classes: list[ClassFiguresOut]
    people: list[PersonFiguresOut]


@router.get("/projects/{p}/statistics", responses=responses(404))
def get_statistics(p: ProjectId, workspace: Ws, who: Caller) -> StatisticsOut:
    """Return points, objects and hours of a project by class and by person, from its edits."""
    found = workspace.projects.statistics(p, who.author, who.role)
    classes = [
        ClassFiguresOut(name=e.name, points=e.points, objects=e.objects, hours=e.seconds / 3600)
        for e in found.classes
    ]
    people = [
        PersonFiguresOut(name=e.account, hours=e.seconds / 3600, edits=e.edits, points=e.points)
        for e in found.people
    ]
    return StatisticsOut(
        recordings=found.recordings,
        labelled_frames=found.labelled_frames,
        points=sum(each.points for each in classes),
        objects=sum(each.objects for each in classes),
        hours=sum(each.hours for each in people),
        classes=classes,
        people=people,
    )


@router.patch("/projects/{p}", responses=responses(404, 409, 413))
def patch_project(p: ProjectId, body: ProjectPatch, workspace: Ws, who: Caller) -> ProjectOut:
    """Change name, roles or categories of a project, or move recordings into it."""
    change = Change(
        body.name,
        body.categories,
        all_categories="categories" in body.model_fields_set and body.categories is None,
        roles=body.roles,
        recordings=body.recordings,
    )
    return ProjectOut.seen(workspace.projects.change(p, change, who.author, who.role))


@router.delete("/projects/{p}", status_code=204, responses=responses(404, 409))
def delete_project(p: ProjectId, workspace: Ws) -> None:
    """Delete a project without recordings, and its tasks; the first project stays."""
    workspace.projects.remove(p)
