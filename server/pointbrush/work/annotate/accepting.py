"""A person vouches for what tracking found in a frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.labels import Commit, LabelStore, Write
from pointbrush.labels.types import PAINTED, TRACKED

Track = dict[str, Any]


def accept(
    store: LabelStore, sequence: str, frame: int, labels: Sequence[int], author: str, edit: str
) -> Commit:
    """Make the labels' points in ``frame`` count as painted and their tracks as sure; one edit.

    A label that was lost there, or has no points, is accepted as not being there.
    Raises NotFoundError (frame, label), LockedLabelError, BadInputError (no labels).
    """
    return accept_range(store, sequence, [frame], labels, author, edit)


def accept_range(
    store: LabelStore,
    sequence: str,
    frames: Sequence[int],
    labels: Sequence[int],
    author: str,
    edit: str,
) -> Commit:
    """Do the same in several frames, as one edit; raises as ``accept``."""

    def theirs(frame: int) -> Write:
        values = store.values(sequence, frame)
        points = np.flatnonzero(np.isin(values.label, labels) & ~values.deleted)
        return Write(points, provenance=PAINTED, living=True)

    def vouched(track: Track) -> Track:
        return {**track, "confidence": 1.0, "state": "painted"}

    require(store, sequence, frames, labels)
    return store.apply(
        sequence,
        edit_id=edit,
        author=author,
        kind="accept",
        writes={frame: theirs(frame) for frame in frames},
        summary=f"accepted {len(labels)} labels in {called(frames)}",
        tracks=list(map(vouched, _tracks(store, sequence, frames, labels))),
    )


def reject_range(
    store: LabelStore,
    sequence: str,
    frames: Sequence[int],
    labels: Sequence[int],
    author: str,
    edit: str,
) -> Commit:
    """Take back what tracking found of labels in frames, as one edit; painted points stay.

    The labels are lost there from then on: someone has still to look.  Raises as ``accept``.
    """
    lost = {"confidence": 0.0, "state": "lost", "points": 0}
    return _take_back(store, sequence, frames, labels, author, edit, "reject", lost)


def clear_range(
    store: LabelStore,
    sequence: str,
    frames: Sequence[int],
    labels: Sequence[int],
    author: str,
    edit: str,
) -> Commit:
    """Do the same, and vouch for the labels not being there: no doubt is left.

    Raises as ``accept``.
    """
    absent = {"confidence": 1.0, "state": "painted", "points": 0}
    return _take_back(store, sequence, frames, labels, author, edit, "clear", absent)


def _take_back(
    store: LabelStore,
    sequence: str,
    frames: Sequence[int],
    labels: Sequence[int],
    author: str,
    edit: str,
    kind: Literal["reject", "clear"],
    left: Track,
) -> Commit:
    """Remove tracked points of labels in frames; ``left`` is what their tracks say then."""

    def found(frame: int) -> Write:
        values = store.values(sequence, frame)
        theirs = np.isin(values.label, labels) & (values.provenance == TRACKED) & ~values.deleted
        return Write(np.flatnonzero(theirs), label=0, provenance=0, living=True)

    require(store, sequence, frames, labels)
    tracks = _tracks(store, sequence, frames, labels)
    return store.apply(
        sequence,
        edit_id=edit,
        author=author,
        kind=kind,
        writes={frame: found(frame) for frame in frames},
        summary=f"{_DONE[kind]} {len(labels)} labels in {called(frames)}",
        tracks=[{**track, **left} for track in tracks if track["state"] != "painted"],
    )


_DONE = {"reject": "rejected", "clear": "cleared"}


def _tracks(
    store: LabelStore, sequence: str, frames: Sequence[int], labels: Sequence[int]
) -> list[Track]:
    wanted = set(frames)
    return [
        track
        for track in store.tracks(sequence)
        if track["frame"] in wanted and track["label"] in labels
    ]


def require(store: LabelStore, sequence: str, frames: Sequence[int], labels: Sequence[int]) -> None:
    """Raise BadInputError (no labels, no frames), NotFoundError or LockedLabelError (a label)."""
    if not labels:
        raise BadInputError("labels: expected at least one, got none")
    if not frames:
        raise BadInputError("frames: expected at least one, got none")
    for label in labels:
        store.require_paintable(sequence, label)


def called(frames: Sequence[int]) -> str:
    """Return words for one frame or several that follow each other."""
    return f"frame {frames[0]}" if len(frames) == 1 else f"frames {frames[0]} to {frames[-1]}"
