"""Recordings: list, manifest, change, delete."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from fastapi import Query

from pointbrush.web.auth import Caller, TheGate, resource
from pointbrush.web.context import SequenceId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import (
    FloorBody,
    SequenceOut,
    SequencePatch,
)
from pointbrush.workspace import Workspace

DeletedQuery = Annotated[bool, Query(description="those that can be restored, newest first")]

IdentityQuery = Annotated[
    str | None, Query(max_length=100, description="of the recording that is meant")
]

router = resource("sequences")


def _out(workspace: Workspace, sequence: str) -> SequenceOut:
    workspace.recording(sequence)
    return SequenceOut.listed(workspace.listing.entry(sequence))


@router.get("/sequences", responses=responses())
def list_sequences(
    workspace: Ws, who: Caller, gate: TheGate, *, deleted: DeletedQuery = False
) -> list[SequenceOut]:
    """All recordings that are for the caller, by name, also damaged ones.

    ``deleted``: those that can be restored.
    """
    if deleted:
        gone = workspace.deletion.deleted()
        return [SequenceOut.removed(e) for e in gone if gate.may_see(who, e.known.id)]
    found = workspace.listing.all()
    return [SequenceOut.listed(entry) for entry in found if gate.may_see(who, entry.id)]


@router.get("/sequences/{seq}", responses=responses(404))
def get_sequence(seq: SequenceId, workspace: Ws) -> SequenceOut:
    """One recording's manifest."""
    return _out(workspace, seq)


@router.patch("/sequences/{seq}", responses=responses(404, 409, 413))
def patch_sequence(seq: SequenceId, patch: SequencePatch, workspace: Ws) -> SequenceOut:
    """Change a recording's name, rate or the transform that stands it on the floor."""
    fields = {name: value for name, value in patch.model_dump().items() if value is not None}
    if patch.room is not None:
        fields["room"] = np.array(patch.room).reshape(4, 4)
    if fields:
        workspace.update_sequence(seq, **fields)
    return _out(workspace, seq)


@router.post("/sequences/{seq}/source-labels", responses=responses(404, 409))
def import_source_labels(seq: SequenceId, workspace: Ws, who: Caller) -> SequenceOut:
    """Bring in the labels in a recording's own files, where they did not come in with it.

    The call can be repeated: they come in once.
    """
    workspace.imports.bring_labels(seq, who.author)
    return _out(workspace, seq)


@router.post("/sequences/{seq}/floor", responses=responses(404, 409, 413))
def stand_on_floor(seq: SequenceId, body: FloorBody, workspace: Ws) -> SequenceOut:
    """Stand a recording on the surface that rays point at; one is enough, three level it better."""
    samples = [sample.model_dump() for sample in body.samples]
    workspace.stand_on_floor(seq, body.frame, samples)
    return _out(workspace, seq)


@router.delete("/sequences/{seq}/floor", responses=responses(404, 409))
def reset_floor(seq: SequenceId, workspace: Ws) -> SequenceOut:
    """Stand a recording as the import found it."""
    workspace.reset_floor(seq)
    return _out(workspace, seq)


@router.delete("/sequences/{seq}", status_code=204, responses=responses(404, 409))
def delete_sequence(seq: SequenceId, workspace: Ws, identity: IdentityQuery = None) -> None:
    """Delete a recording with everything painted on it; it can be restored for 30 days.

    With the ``identity`` of its manifest the call can be repeated, and deletes no other one.
    """
    workspace.deletion.delete(seq, identity)


@router.post("/sequences/{seq}/restore", responses=responses(404, 409))
def restore_sequence(seq: SequenceId, workspace: Ws) -> SequenceOut:
    """Bring a deleted recording back with all its labels, by its id or its ``identity``.

    Of several with this id the last one deleted.  If the id is taken meanwhile, it gets another.
    By its ``identity`` the call can be repeated.
    """
    return SequenceOut.listed(workspace.listing.entry(workspace.deletion.restore(seq)))
