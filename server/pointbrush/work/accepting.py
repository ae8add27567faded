"""A person vouches for what tracking found in a frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.labels import Commit, LabelStore, Write
from pointbrush.labels.types import PAINTED


def accept(
    store: LabelStore, sequence: str, frame: int, labels: Sequence[int], author: str, edit: str
) -> Commit:
    """Make the labels' points in ``frame`` count as painted and their tracks as sure; one edit.

    A label that was lost there, or has no points, is accepted as not being there.
    Raises NotFoundError (frame, label), LockedLabelError, BadInputError (no labels).
    """
    if not labels:
        raise BadInputError("labels: expected at least one to accept, got none")
    for label in labels:
        store.require_paintable(sequence, label)
    values = store.values(sequence, frame)
    tracks = [
        {**track, "confidence": 1.0, "state": "painted"}
        for track in store.tracks(sequence)
        if track["frame"] == frame and track["label"] in labels
    ]
    mine = np.flatnonzero(np.isin(values.label, labels) & ~values.deleted)
    return store.apply(
        sequence,
        edit_id=edit,
        author=author,
        kind="accept",
        writes={frame: Write(mine, provenance=PAINTED, living=True)},
        summary=f"accepted {len(labels)} labels in frame {frame}",
        tracks=tracks,
    )
