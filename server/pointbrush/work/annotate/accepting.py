"""Verdicts of people on the labels that tracking found in frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.labels import Commit, FrameValues, LabelStore, Write
from pointbrush.labels.types import PAINTED, PREDICTED, TRACKED
from pointbrush.work.annotate.strokes import edit_id
from pointbrush.work.part import Part

Verdict = Literal["accept", "reject", "clear"]
"""Accept: points become painted, tracks certain; a label without points is confirmed as absent.

Reject: tracked points lose the label; its track is lost there and still has to be checked.
Clear: tracked points lose the label, and the label is confirmed as absent.
"""
_DONE = {"accept": "accepted", "reject": "rejected", "clear": "cleared"}
_LEFT: dict[str, dict[str, Any]] = {
    "accept": {"confidence": 1.0, "state": "painted"},
    "reject": {"confidence": 0.0, "state": "lost", "points": 0},
    "clear": {"confidence": 1.0, "state": "painted", "points": 0},
}
"""The fields of labels' tracks after each verdict."""


class Verdicts(Part):
    """Verdicts of people on results of tracking."""

    def give(
        self,
        verdict: Verdict,
        sequence: str,
        frames: Sequence[int],
        labels: Sequence[int],
        author: str,
        edit: str | None = None,
    ) -> Commit:
        """Judge labels in frames, as one edit; painted points never lose their label.

        Raises NotFoundError (frame, label), LockedLabelError, BadInputError (no labels, no frames).
        """
        recording = self._recording(sequence)
        for frame in frames:
            _ = recording[frame]
        require(self._store, sequence, frames, labels)
        write = _accepted if verdict == "accept" else _taken_back
        return self._store.apply(
            sequence,
            edit_id=edit_id(edit),
            author=author,
            kind=verdict,
            writes={frame: write(self._store.values(sequence, frame), labels) for frame in frames},
            summary=f"{_DONE[verdict]} {len(labels)} labels in {called(frames)}",
            tracks=[
                {**track, **_LEFT[verdict]}
                for track in self._store.tracks(sequence)
                if track["frame"] in frames
                and track["label"] in labels
                and (verdict == "accept" or track["state"] != "painted")
            ],
        )


def _accepted(values: FrameValues, labels: Sequence[int]) -> Write:
    points = np.flatnonzero(np.isin(values.label, labels) & ~values.deleted)
    return Write(points, provenance=PAINTED, living=True)


def _taken_back(values: FrameValues, labels: Sequence[int]) -> Write:
    found = np.isin(values.provenance, (TRACKED, PREDICTED))
    theirs = np.isin(values.label, labels) & found
    return Write(np.flatnonzero(theirs & ~values.deleted), label=0, provenance=0, living=True)


def require(store: LabelStore, sequence: str, frames: Sequence[int], labels: Sequence[int]) -> None:
    """Raise BadInputError (no labels, no frames), NotFoundError or LockedLabelError (a label)."""
    if not labels:
        raise BadInputError("labels: expected at least one, got none")
    if not frames:
        raise BadInputError("frames: expected at least one, got none")
    for label in labels:
        store.require_paintable(sequence, label)


def called(frames: Sequence[int]) -> str:
    """Return a phrase for one frame or several consecutive frames."""
    return f"frame {frames[0]}" if len(frames) == 1 else f"frames {frames[0]} to {frames[-1]}"
