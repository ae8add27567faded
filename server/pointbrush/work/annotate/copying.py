"""Labels of one frame in another one at the same place, and taken away from frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.labels import Commit, LabelStore, Write
from pointbrush.labels.types import PAINTED
from pointbrush.selection.points import near, reach_of
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.accepting import called, require
from pointbrush.work.annotate.overlays import placements
from pointbrush.work.annotate.painted_frame import frame_points

SPACINGS = 1.5
"""Points belong to an object within this many times the spacing of its points."""


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
    require(store, recording.manifest.id, [frame], labels)
    if frame == source:
        raise BadInputError(f"source: expected another frame than {frame}, got the same")
    placed = placements(store, recording, frame, [source])[-1]
    values = store.values(recording.manifest.id, source)
    xyz, points = recording[source].coordinates, frame_points(recording[frame])

    def writes() -> Iterator[tuple[int, Write]]:
        for label in labels:
            mine = np.flatnonzero((values.label == label) & ~values.deleted)
            T = placed.moving.get(label, placed.T_shown_frame)
            moved = xyz[mine] @ T[:3, :3].T + T[:3, 3]
            found = near(points, moved, reach_of(moved, SPACINGS))
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
    require(store, recording.manifest.id, frames, labels)
    for frame in frames:
        _ = recording[frame]
    sequence = recording.manifest.id

    def theirs(frame: int) -> Write:
        values = store.values(sequence, frame)
        points = np.flatnonzero(np.isin(values.label, labels))
        return Write(points, label=0, provenance=0)

    return store.apply(
        sequence,
        edit_id=edit,
        author=author,
        kind="clear",
        writes=((frame, theirs(frame)) for frame in frames),
        summary=f"cleared {len(labels)} labels in {called(frames)}",
    )
