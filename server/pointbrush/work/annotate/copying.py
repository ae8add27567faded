"""Copying labels from one frame to the same place in another, and removing labels from frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.labels import Commit, Write
from pointbrush.labels.types import PAINTED
from pointbrush.selection.points import near, reach_of
from pointbrush.work.annotate.accepting import called, require
from pointbrush.work.annotate.overlays import placements
from pointbrush.work.annotate.painted_frame import frame_points
from pointbrush.work.annotate.strokes import edit_id
from pointbrush.work.part import Part

SPACINGS = 1.5
"""Points belong to an object within this many times the spacing of its points."""


class Copying(Part):
    """Copies of labels to another frame, and removal of labels."""

    def copy(
        self,
        sequence: str,
        frame: int,
        source: int,
        labels: Sequence[int],
        author: str,
        edit: str | None = None,
    ) -> Commit:
        """Give points of ``frame`` the labels of points at their place in ``source``, as one edit.

        The world is static between the two frames, except labels with tracks in both frames, which
        move by their tracks.  Points that have a label keep it.  Raises NotFoundError (frame,
        label), LockedLabelError, BadInputError (no labels, or the same frame).
        """
        recording = self._recording(sequence)
        require(self._store, sequence, [frame], labels)
        if frame == source:
            raise BadInputError(f"source: expected another frame than {frame}, got the same")
        placed = placements(self._store, recording, frame, [source])[-1]
        values = self._store.values(sequence, source)
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

        return self._store.apply(
            sequence,
            edit_id=edit_id(edit),
            author=author,
            kind="copy",
            writes=writes(),
            summary=f"copied {len(labels)} labels from frame {source} to frame {frame}",
        )

    def clear(
        self,
        sequence: str,
        frames: Sequence[int],
        labels: Sequence[int],
        author: str,
        edit: str | None = None,
    ) -> Commit:
        """Remove labels from all their points in frames, including painted points, as one edit.

        Raises NotFoundError (frame, label), LockedLabelError, BadInputError (no labels, no frames).
        """
        recording = self._recording(sequence)
        require(self._store, sequence, frames, labels)
        for frame in frames:
            _ = recording[frame]

        def theirs(frame: int) -> Write:
            values = self._store.values(sequence, frame)
            points = np.flatnonzero(np.isin(values.label, labels))
            return Write(points, label=0, provenance=0)

        return self._store.apply(
            sequence,
            edit_id=edit_id(edit),
            author=author,
            kind="clear",
            writes=((frame, theirs(frame)) for frame in frames),
            summary=f"cleared {len(labels)} labels in {called(frames)}",
        )
