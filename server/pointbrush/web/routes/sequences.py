"""Recordings: list, manifest, change, delete."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from fastapi import Depends, Query

from pointbrush.accounts.roles import includes
from pointbrush.teamwork.access import COMPARES
from pointbrush.teamwork.summaries import Search
from pointbrush.values.kinds import TaskState
from pointbrush.values.recordings import Manifest, RecordingPatch
from pointbrush.web.context import SequenceId, Ws, id_query
from pointbrush.web.security.auth import Caller, TheGate, resource
from pointbrush.web.security.roles import needs
from pointbrush.web.strokes import FloorBody
from pointbrush.work.manifests import removed
from pointbrush.workspace import Workspace

CopiesQuery = Annotated[
    bool, Query(description="include the copies of several people; for reviewers")
]
DeletedQuery = Annotated[
    bool, Query(description="recordings that can be restored, the newest first")
]

IdentityQuery = Annotated[
    str | None, Query(max_length=100, description="of the recording that is meant")
]

router = resource("sequences")
Word = Annotated[str | None, Query(min_length=1, max_length=256)]


@dataclass(frozen=True)
class SearchQuery:
    """A search for recordings, and a part of their name or id."""

    search: Search
    text: str


def search_query(
    project: Annotated[str | None, id_query("id of its project")] = None,
    q: Annotated[str, Query(max_length=256, description="a part of the name or id")] = "",
    category: Annotated[
        str | None,
        Query(alias="class", min_length=1, max_length=256, description="with points of it"),
    ] = None,
    label: Annotated[Word, Query(description="name of a label that has points in it")] = None,
    state: Annotated[TaskState | None, Query(description="state of one of its tasks")] = None,
    person: Annotated[
        Word, Query(description="account that has a task in it, or edited it")
    ] = None,
) -> SearchQuery | None:
    """Return the search that a call asks for, if any."""
    search = Search(project, category, label, state, person)
    return SearchQuery(search, q) if q or search != Search() else None


def _out(workspace: Workspace, sequence: str) -> Manifest:
    workspace.recording(sequence)
    return workspace.listing.entry(sequence)


@router.get("/sequences", **needs("viewer"))
def list_sequences(
    workspace: Ws,
    who: Caller,
    gate: TheGate,
    wanted: Annotated[SearchQuery | None, Depends(search_query)],
    *,
    deleted: DeletedQuery = False,
    copies: CopiesQuery = False,
) -> list[Manifest]:
    """List the recordings that the caller may open, by name, damaged ones included.

    ``deleted``: recordings that can be restored.  A search finds only recordings that can be
    opened.  An annotator with a copy sees the copy instead of the recording.
    """
    if deleted:
        gone = workspace.deletion.deleted()
        return [removed(e) for e in gone if gate.may_see_deleted(who, e.known)]
    if wanted is None:
        found = workspace.listing.all(copies=True)
    else:
        found = workspace.listing.search(wanted.search, wanted.text)
    roles = gate.roles_in(who, (entry.id for entry in found))
    shown = []
    for entry in found:
        if entry.copy_of is not None and includes(roles.get(entry.id, "viewer"), COMPARES):
            shown += [entry] if copies else []
        elif entry.id in roles:
            shown.append(replace(entry, copy_of=None))
    return shown


@router.get("/sequences/{seq}", **needs("viewer", 404))
def get_sequence(seq: SequenceId, workspace: Ws) -> Manifest:
    """Return the manifest of a recording."""
    return _out(workspace, seq)


@router.patch("/sequences/{seq}", **needs("manager", 404, 409, 413))
def patch_sequence(seq: SequenceId, patch: RecordingPatch, workspace: Ws) -> Manifest:
    """Change the name, the rate or the floor transform of a recording."""
    fields = patch.to_json()
    if patch.room is not None:
        fields["room"] = np.array(patch.room).reshape(4, 4)
    if fields:
        workspace.update_sequence(seq, **fields)
    return _out(workspace, seq)


@router.post("/sequences/{seq}/source-labels", **needs("annotator", 404, 409))
def import_source_labels(seq: SequenceId, workspace: Ws, who: Caller) -> Manifest:
    """Import the labels in a recording's own files, unless its import has done so.

    The call can be repeated: the labels are imported once.
    """
    workspace.imports.import_source_labels(seq, who.author)
    return _out(workspace, seq)


@router.post("/sequences/{seq}/floor", **needs("annotator", 404, 409, 413))
def stand_on_floor(seq: SequenceId, body: FloorBody, workspace: Ws) -> Manifest:
    """Place a recording on the surface that rays point at; one is enough, three level it better."""
    samples = [sample.model_dump() for sample in body.samples]
    workspace.stand_on_floor(seq, body.frame, samples)
    return _out(workspace, seq)


@router.delete("/sequences/{seq}/floor", **needs("annotator", 404, 409))
def reset_floor(seq: SequenceId, workspace: Ws) -> Manifest:
    """Place a recording on the floor that the import found."""
    workspace.reset_floor(seq)
    return _out(workspace, seq)


@router.delete("/sequences/{seq}", status_code=204, **needs("manager", 404, 409))
def delete_sequence(seq: SequenceId, workspace: Ws, identity: IdentityQuery = None) -> None:
    """Delete a recording with its labels; it can be restored for 30 days.

    With the ``identity`` of its manifest the call can be repeated without deleting another one.
    """
    workspace.deletion.delete(seq, identity)


@router.post("/sequences/{seq}/restore", **needs("manager", 404, 409))
def restore_sequence(seq: SequenceId, workspace: Ws) -> Manifest:
    """Restore a deleted recording with all its labels, by its id or its ``identity``.

    If several have this id, the last deleted one is restored.  If the id is in use, the recording
    gets another id.  With the ``identity`` the call can be repeated.
    """
    return workspace.listing.entry(workspace.deletion.restore(seq))
