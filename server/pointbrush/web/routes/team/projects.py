"""Projects: recordings in groups, with people's roles and a selection of the categories."""

from __future__ import annotations

from fastapi import Response

from pointbrush.values.team.projects import (
    NewProject,
    ProjectInfo,
    ProjectPatch,
    Statistics,
)
from pointbrush.web.context import ProjectId, Ws
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs

router = resource("projects")


@router.get("/projects", **needs("viewer"))
def list_projects(workspace: Ws, who: Caller) -> list[ProjectInfo]:
    """List the projects that the caller may open, by name."""
    return workspace.projects.all(who.author, who.role)


@router.post("/projects", status_code=201, **needs("manager", 404, 409, 413))
def create_project(body: NewProject, response: Response, workspace: Ws, who: Caller) -> ProjectInfo:
    """Create a project; its id derives from its name unless one is given."""
    made = workspace.projects.create(body, body.id, who.author, who.role)
    response.headers["Location"] = f"/api/v1/projects/{made.id}"
    return made


@router.get("/projects/{p}", **needs("viewer", 404))
def get_project(p: ProjectId, workspace: Ws, who: Caller) -> ProjectInfo:
    """Return a project."""
    return workspace.projects.get(p, who.author, who.role)


@router.get("/projects/{p}/statistics", **needs("viewer", 404))
def get_statistics(p: ProjectId, workspace: Ws, who: Caller) -> Statistics:
    """Return points, objects and hours of a project by class and by person, from its edits."""
    return workspace.projects.statistics(p, who.author, who.role)


@router.patch("/projects/{p}", **needs("manager", 404, 409, 413))
def patch_project(p: ProjectId, body: ProjectPatch, workspace: Ws, who: Caller) -> ProjectInfo:
    """Change name, roles or categories of a project, or move recordings into it."""
    return workspace.projects.change(p, body, who.author, who.role)


@router.delete("/projects/{p}", status_code=204, **needs("manager", 404, 409))
def delete_project(p: ProjectId, workspace: Ws) -> None:
    """Delete a project without recordings, and its tasks; the first project stays."""
    workspace.projects.remove(p)
