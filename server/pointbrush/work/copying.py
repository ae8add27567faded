"""Labels of one frame in another one at the same place, and taken away from frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.labels import Commit, LabelStore, Write
from pointbrush.labels.types import PAINTED
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.placing import placements

REACH = 1.5
"""Points belong to an object within this many times the spacing of its points."""
LEAST_REACH = 0.005
"""Metres."""


def copy_labels(
    store: LabelStore,
    recording: Recording,
    frame: int,
    source: int,
    labels: Sequence[int],
    author: str,
    edit: str,
) -> Commit:
    """Give points of ``frame`` the labels that points at their place have in ``source``; one edit.

    The world stands still between the two; a label with tracks in both moves as they say.  Points
    that have a label keep it.  Raises NotFoundError (frame, label), LockedLabelError,
    BadInputError (no labels, or the same frame).
    """
    _require(store, recording, labels)
    if frame == source:
        raise BadInputError(f"source: expected another frame than {frame}, got the same")
    placed = placements(store, recording, frame, [source])[-1]
    values = store.values(recording.manifest.id, source)
    xyz = recording[source].xyz

    def writes() -> Iterator[tuple[int, Write]]:
        for label in labels:
            mine = np.flatnonzero((values.label == label) & ~values.deleted)
            T = placed.moving.get(label, placed.T_shown_frame)
            moved = xyz[mine] @ T[:3, :3].T + T[:3, 3]
            found = _near(recording[frame].xyz, moved)
            yield (
                frame,
                Write(found, label=label, provenance=PAINTED, only="unlabeled", living=True),
            )

    return store.apply(
        recording.manifest.id,
        edit_id=edit,
        author=author,
        kind="copy",
        writes=writes(),
        summary=f"copied {len(labels)} labels from frame {source} to frame {frame}",
    )


def clear_labels(
    store: LabelStore,
    recording: Recording,
    frames: Sequence[int],
    labels: Sequence[int],
    author: str,
    edit: str,
) -> Commit:
    """Take labels from all of their points in frames, painted ones too, as one edit.

    Raises NotFoundError (frame, label), LockedLabelError, BadInputError (no labels, no frames).
    """
    _require(store, recording, labels)
    if not frames:
        raise BadInputError("frames: expected at least one, got none")
    for frame in frames:
        _ = recording[frame]
    sequence = recording.manifest.id

    def theirs(frame: int) -> Write:
        values = store.values(sequence, frame)
        points = np.flatnonzero(np.isin(values.label, labels))
        return Write(points, label=0, provenance=0)

    called = f"frame {frames[0]}" if len(frames) == 1 else f"frames {frames[0]} to {frames[-1]}"
    return store.apply(
        sequence,
        edit_id=edit,
        author=author,
        kind="clear",
        writes=((frame, theirs(frame)) for frame in frames),
        summary=f"cleared {len(labels)} labels in {called}",
    )


def _require(store: LabelStore, recording: Recording, labels: Sequence[int]) -> None:
    if not labels:
        raise BadInputError("labels: expected at least one, got none")
    for label in labels:
        store.require_paintable(recording.manifest.id, label)


def _near(xyz: NDArray[np.float32], object_points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Numbers of points (N, 3) that lie among an object's points (M, 3)."""
    from scipy.spatial import cKDTree

    if len(object_points) == 0:
        return np.empty(0, np.int64)
    tree = cKDTree(object_points)
    reach = LEAST_REACH
    if len(object_points) > 1:
        distances = np.asarray(tree.query(object_points, k=2)[0])
        reach = max(reach, REACH * float(np.median(distances[:, 1])))
    low, high = object_points.min(axis=0) - reach, object_points.max(axis=0) + reach
    around = np.flatnonzero(((xyz >= low) & (xyz <= high)).all(axis=1))
    distance = tree.query(xyz[around], distance_upper_bound=reach)[0]
    found: NDArray[np.int64] = around[np.isfinite(distance)]
    return found
