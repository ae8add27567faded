"""Named versions of a project's labels, and their differences."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated

from fastapi import Path, Query, Response

from pointbrush.web.auth import Caller, TheGate, resource
from pointbrush.web.context import SEQUENCE_ID, ProjectId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import Body, Name, Out
from pointbrush.work.projects.versions import Kind

router = resource("snapshots")
SnapshotId = Annotated[str, Path(pattern=SEQUENCE_ID, max_length=64, description="snapshot id")]


class SnapshotBody(Body):
    """A version to create."""

    name: Name


class SnapshotOut(Out):
    """A version: the revisions of the recordings at its time."""

    id: str
    name: str
    created: datetime
    author: str
    recordings: dict[str, int]


class LabelDifferenceOut(Out):
    """A label that was added, removed, or has another name, category or colour."""

    label: int
    name: str
    kind: Kind


class FrameDifferenceOut(Out):
    """Points with a new, removed or different label; labels with points in one version only."""

    frame: int
    came: int
    went: int
    changed: int
    objects_came: list[int]
    objects_went: list[int]


class DifferenceOut(Out):
    """Difference of a recording's labels; equal parts are left out."""

    sequence: str
    labels: list[LabelDifferenceOut]
    frames: list[FrameDifferenceOut]


@router.get("/projects/{p}/snapshots", responses=responses(404))
def list_snapshots(p: ProjectId, workspace: Ws) -> list[SnapshotOut]:
    """List the versions of a project's labels, the newest first."""
    return [SnapshotOut.of(each) for each in workspace.versions.all(p)]


@router.post("/projects/{p}/snapshots", status_code=201, responses=responses(404, 409, 413))
def create_snapshot(
    p: ProjectId, body: SnapshotBody, response: Response, workspace: Ws, who: Caller
) -> SnapshotOut:
    """Store the current labels of a project as a named version."""
    made = workspace.versions.create(p, body.name, who.author)
    response.headers["Location"] = f"/api/v1/projects/{p}/snapshots/{made.id}"
    return SnapshotOut.of(made)


@router.get("/projects/{p}/snapshots/{s}", responses=responses(404))
def get_snapshot(p: ProjectId, s: SnapshotId, workspace: Ws) -> SnapshotOut:
    """Return a version."""
    return SnapshotOut.of(workspace.versions.get(p, s))


@router.delete("/projects/{p}/snapshots/{s}", status_code=204, responses=responses(404))
def delete_snapshot(p: ProjectId, s: SnapshotId, workspace: Ws) -> None:
    """Delete a version; labels stay."""
    workspace.versions.remove(p, s)


@router.get("/projects/{p}/snapshots/{s}/difference", responses=responses(404))
def get_difference(
    p: ProjectId,
    s: SnapshotId,
    workspace: Ws,
    who: Caller,
    gate: TheGate,
    other: Annotated[
        str | None,
        Query(
            alias="with",
            pattern=SEQUENCE_ID,
            max_length=64,
            description="another snapshot; by default the current labels",
        ),
    ] = None,
    sequence: Annotated[
        str | None, Query(pattern=SEQUENCE_ID, max_length=64, description="only of this recording")
    ] = None,
) -> list[DifferenceOut]:
    """Return the difference of two versions by frame, for the recordings that both have."""
    found = workspace.versions.difference(p, s, other, sequence)
    roles = gate.roles_in(who, (each.sequence for each in found))
    return [DifferenceOut.of(each) for each in found if each.sequence in roles]
