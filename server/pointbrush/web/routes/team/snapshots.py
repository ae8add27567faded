"""Named versions of a project's labels, and their differences."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path, Response

from pointbrush.values.team.snapshots import Difference, NewSnapshot, Snapshot
from pointbrush.web.context import SEQUENCE_ID, ProjectId, RecordingQuery, Ws, id_query
from pointbrush.web.security.auth import Caller, TheGate, resource
from pointbrush.web.security.roles import needs

router = resource("snapshots")
Other = Annotated[str | None, id_query("another snapshot; by default the current labels", "with")]
SnapshotId = Annotated[str, Path(pattern=SEQUENCE_ID, max_length=64, description="snapshot id")]


@router.get("/projects/{p}/snapshots", **needs("viewer", 404))
def list_snapshots(p: ProjectId, workspace: Ws) -> list[Snapshot]:
    """List the versions of a project's labels, the newest first."""
    return workspace.versions.all(p)


@router.post("/projects/{p}/snapshots", status_code=201, **needs("manager", 404, 409, 413))
def create_snapshot(
    p: ProjectId, body: NewSnapshot, response: Response, workspace: Ws, who: Caller
) -> Snapshot:
    """Store the current labels of a project as a named version."""
    made = workspace.versions.create(p, body.name, who.author)
    response.headers["Location"] = f"/api/v1/projects/{p}/snapshots/{made.id}"
    return made


@router.get("/projects/{p}/snapshots/{s}", **needs("viewer", 404))
def get_snapshot(p: ProjectId, s: SnapshotId, workspace: Ws) -> Snapshot:
    """Return a version."""
    return workspace.versions.get(p, s)


@router.delete("/projects/{p}/snapshots/{s}", status_code=204, **needs("manager", 404))
def delete_snapshot(p: ProjectId, s: SnapshotId, workspace: Ws) -> None:
    """Delete a version; labels stay."""
    workspace.versions.remove(p, s)


@router.get("/projects/{p}/snapshots/{s}/difference", **needs("viewer", 404))
def get_difference(
    p: ProjectId,
    s: SnapshotId,
    workspace: Ws,
    who: Caller,
    gate: TheGate,
    other: Other = None,
    sequence: RecordingQuery = None,
) -> list[Difference]:
    """Return the difference of two versions by frame, for the recordings that both have."""
    found = workspace.versions.difference(p, s, other, sequence)
    roles = gate.roles_in(who, (each.sequence for each in found))
    return [each for each in found if each.sequence in roles]
