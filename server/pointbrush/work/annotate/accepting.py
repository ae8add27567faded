"""A person vouches for what tracking found in a frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.labels import Commit, LabelStore, Write
from pointbrush.labels.types import PAINTED, TRACKED

Track = dict[str, Any]
_DONE = {"reject": "rejected", "clear": "cleared"}


@dataclass(frozen=True, slots=True)
class Judgement:
    """A person's word on ``labels`` in ``frames`` of a sequence; ``edit`` is its edit's id."""

    sequence: str
    frames: Sequence[int]
    labels: Sequence[int]
    author: str
    edit: str


def accept(store: LabelStore, judged: Judgement) -> Commit:
    """Make the labels' points in the frames count as painted and their tracks as sure; one edit.

    A label that was lost there, or has no points, is accepted as not being there.
    Raises NotFoundError (frame, label), LockedLabelError, BadInputError (no labels).
    """

    def theirs(frame: int) -> Write:
        values = store.values(judged.sequence, frame)
        points = np.flatnonzero(np.isin(values.label, judged.labels) & ~values.deleted)
        return Write(points, provenance=PAINTED, living=True)

    require(store, judged.sequence, judged.frames, judged.labels)
    sure = {"confidence": 1.0, "state": "painted"}
    return store.apply(
        judged.sequence,
        edit_id=judged.edit,
        author=judged.author,
        kind="accept",
        writes={frame: theirs(frame) for frame in judged.frames},
        summary=f"accepted {len(judged.labels)} labels in {called(judged.frames)}",
        tracks=[{**track, **sure} for track in _tracks(store, judged)],
    )


def reject(store: LabelStore, judged: Judgement) -> Commit:
    """Take back what tracking found of labels in frames, as one edit; painted points stay.

    The labels are lost there from then on: someone has still to look.  Raises as ``accept``.
    """
    return _take_back(store, judged, "reject", {"confidence": 0.0, "state": "lost", "points": 0})


def clear(store: LabelStore, judged: Judgement) -> Commit:
    """Do the same, and vouch for the labels not being there: no doubt is left.

    Raises as ``accept``.
    """
    return _take_back(store, judged, "clear", {"confidence": 1.0, "state": "painted", "points": 0})


def _take_back(
    store: LabelStore, judged: Judgement, kind: Literal["reject", "clear"], left: Track
) -> Commit:
    """Remove tracked points of labels in frames; ``left`` is what their tracks say then."""

    def found(frame: int) -> Write:
        values = store.values(judged.sequence, frame)
        theirs = np.isin(values.label, judged.labels) & (values.provenance == TRACKED)
        return Write(np.flatnonzero(theirs & ~values.deleted), label=0, provenance=0, living=True)

    require(store, judged.sequence, judged.frames, judged.labels)
    tracks = _tracks(store, judged)
    return store.apply(
        judged.sequence,
        edit_id=judged.edit,
        author=judged.author,
        kind=kind,
        writes={frame: found(frame) for frame in judged.frames},
        summary=f"{_DONE[kind]} {len(judged.labels)} labels in {called(judged.frames)}",
        tracks=[{**track, **left} for track in tracks if track["state"] != "painted"],
    )


def _tracks(store: LabelStore, judged: Judgement) -> list[Track]:
    wanted = set(judged.frames)
    return [
        track
        for track in store.tracks(judged.sequence)
        if track["frame"] in wanted and track["label"] in judged.labels
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
