"""Replay of a task: the edits that its log names, applied again in their order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from pointbrush.errors import ConflictError
from pointbrush.labels.draft import Changes
from pointbrush.labels.packing import (
    BLOCK,
    DELETION,
    LABELS,
    States,
    confidence_of,
    deleted_of,
    label_of,
    provenance_of,
)
from pointbrush.labels.types import EditInfo, FrameValues
from pointbrush.sequences import Sequence as Recording
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.teamwork.studies import Record

LAYERS = ("label", "provenance", "confidence", "deleted")


class Replayed:
    """The labels of a recording after edits that are applied one by one."""

    def __init__(self, points: Sequence[int]) -> None:
        """``points``: number of points of each frame."""
        self._points, self._words = points, dict[tuple[int, int], States]()

    def apply(self, changes: Changes) -> set[int]:
        """Apply an edit; return the frames that it changes."""
        for (frame, layer, block), change in changes.items():
            self._of(frame, layer)[change.indices + block * BLOCK] = change.after
        return {frame for frame, _, _ in changes}

    def values(self, frame: int) -> FrameValues:
        """Return the annotation of a frame."""
        words = self._of(frame, LABELS)
        deleted = deleted_of(self._of(frame, DELETION))
        return FrameValues(
            label_of(words), provenance_of(words), deleted, confidence_of(words), 0, 0
        )

    def _of(self, frame: int, layer: int) -> States:
        none = np.zeros(self._points[frame], np.uint64)
        return self._words.setdefault((frame, layer), none)


def matched(edits: Iterable[EditInfo], records: Iterable[Record]) -> list[tuple[EditInfo, Record]]:
    """Return the records of edits in their order, each with its edit.

    A record has the id of its edit; undos and redos without one match by their order.
    """
    known, found = [*edits], list[tuple[EditInfo, Record]]()
    by_id = {each.id.lower(): each for each in known}
    by_kind = {kind: iter([e for e in known if e.kind == kind]) for kind in ("undo", "redo")}
    for record in records:
        key = record.get("id", "").lower()
        edit = by_id.get(key) if key else next(by_kind.get(record["kind"], iter(())), None)
        if edit:
            found.append((edit, record))
    return found


def replay(store: WorkspaceStore, recording: Recording, records: Sequence[Record]) -> int:
    """Apply the edits of a log, and compare the result with the labels of the recording.

    Returns the number of edits; raises ConflictError with the first difference.
    """
    sequence = recording.manifest.id
    changes = {e.id: (e, found) for e, found in store.changes(sequence) if e.kind != "import"}
    logged = [edit.id for edit, _ in matched([edit for edit, _ in changes.values()], records)]
    for edit, _ in changes.values():
        if edit.id not in logged:
            raise ConflictError(f"the log has no record of edit {edit.id} ({edit.summary})")
    for key, count in Counter(logged).items():
        if count > 1:
            raise ConflictError(f"the log has edit {key} {count} times")
    replayed = Replayed(recording.manifest.points)
    for key in logged:
        replayed.apply(changes[key][1])
    for frame in range(len(recording)):
        _compare(recording, frame, store.values(sequence, frame), replayed.values(frame))
    return len(logged)


def _compare(recording: Recording, frame: int, kept: FrameValues, found: FrameValues) -> None:
    for layer in LAYERS:
        own, other = getattr(kept, layer), getattr(found, layer)
        differs = np.flatnonzero(own != other)
        if len(differs):
            source = recording[frame].source_index[differs]
            at = differs[source.argmin()]
            raise ConflictError(
                f"frame {frame}, point {source.min()}: the {layer} is {own[at]}, the log leads to "
                f"{other[at]} ({len(differs):,} points differ in this frame)"
            )
