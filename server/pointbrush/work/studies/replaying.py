"""Replay of a session: the log's edits in order on new labels, compared with the kept ones."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from pointbrush.errors import ConflictError
from pointbrush.labels import LabelStore, Write
from pointbrush.labels.draft import Changes
from pointbrush.labels.packing import (
    BLOCK,
    LABELS,
    confidence_of,
    deleted_of,
    label_of,
    provenance_of,
)
from pointbrush.sequences import Sequence as Recording
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.studies import Record
from pointbrush.values.study import Replay

WHO = "participant"
LAYERS = ("label", "provenance", "confidence", "deleted")


def replay(
    store: WorkspaceStore, copies: Mapping[str, tuple[Recording, Sequence[Record]]]
) -> Replay:
    """Compare the labels of copies with the result of their records.

    ``copies``: recording and records by a name for people.
    """
    applied = 0
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(LabelStore(f"sqlite:///{Path(folder) / 'labels.sqlite'}")) as fresh,
    ):
        for name, (recording, records) in copies.items():
            try:
                applied += _apply_all(store, fresh, recording, records)
                _compare(store, fresh, recording)
            except ConflictError as difference:
                return Replay(False, applied, f"{name}: {difference}")
    return Replay(True, applied, "")


def _apply_all(
    store: WorkspaceStore, fresh: LabelStore, recording: Recording, records: Sequence[Record]
) -> int:
    """Apply the edits of the records; raises ConflictError if the labels have other edits."""
    sequence = recording.manifest.id
    fresh.recordings.register(sequence, recording.manifest.points)
    for label in store.palette(sequence):
        fresh.create_label(sequence, "import", name=label.name, id=label.id, color=label.color)
    made = {edit.id.lower(): (edit, changes) for edit, changes in store.changes(sequence)}
    missing = [key for key in made if made[key][0].kind not in ("undo", "redo", "import")]
    applied = 0
    for record in records:
        kind, key = record["kind"], record.get("id", "").lower()
        if kind == "stroke" and key in made:
            if key not in missing:
                raise ConflictError(f"the log has edit {key} twice")
            missing.remove(key)
            edit, changes = made[key]
            fresh.apply(
                sequence, edit_id=edit.id, author=WHO, kind=edit.kind, writes=_writes(changes),
                summary=edit.summary,
            )  # fmt: skip
        elif kind in ("undo", "redo"):
            try:
                (fresh.undo if kind == "undo" else fresh.redo)(sequence, WHO)
            except ConflictError as error:
                raise ConflictError(f"{kind} at {record['t'] / 1000:.1f} s: {error}") from None
        else:
            continue
        applied += 1
    if missing:
        edit = made[missing[0]][0]
        raise ConflictError(f"the log has no record of edit {edit.id} ({edit.summary})")
    return applied


def _writes(changes: Changes) -> Iterator[tuple[int, Write]]:
    for (frame, layer, block), change in changes.items():
        at, after = change.indices + block * BLOCK, change.after
        if layer == LABELS:
            yield frame, Write(
                at, label=label_of(after), provenance=provenance_of(after),
                confidence=confidence_of(after),
            )  # fmt: skip
        else:
            yield frame, Write(at, deleted=deleted_of(after))


def _compare(store: WorkspaceStore, fresh: LabelStore, recording: Recording) -> None:
    sequence = recording.manifest.id
    for frame in range(len(recording)):
        kept, found = store.values(sequence, frame), fresh.values(sequence, frame)
        for layer in LAYERS:
            own, other = getattr(kept, layer), getattr(found, layer)
            differs = np.flatnonzero(own != other)
            if len(differs):
                first = int(recording[frame].source_index[differs].min())
                at = differs[recording[frame].source_index[differs].argmin()]
                raise ConflictError(
                    f"frame {frame}, point {first}: the {layer} is {own[at]}, the log leads to "
                    f"{other[at]} ({len(differs):,} points differ in this frame)"
                )
