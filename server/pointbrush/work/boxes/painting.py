"""Labelling the points inside a box."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.geometry.oriented_box import OrientedBox
from pointbrush.geometry.quaternions import rotation_of
from pointbrush.labels import Commit, Write
from pointbrush.labels.types import PAINTED, Only
from pointbrush.selection.box import box as points_in
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.painted_frame import frame_points
from pointbrush.work.annotate.strokes import edit_id
from pointbrush.work.exporting import parse_frames
from pointbrush.work.part import Part


class BoxPainting(Part):
    """Points labelled by boxes."""

    def paint(
        self,
        sequence: str,
        box: int,
        author: str,
        *,
        frames: str | None = None,
        only_unlabeled: bool = False,
        edit: str | None = None,
    ) -> Commit:
        """Give the points inside a box its label, in its frames ``I:J``, by default all.

        It is one edit with the rules of a stroke of the shape ``box``: deleted points and points of
        locked or hidden labels are not changed.  Raises NotFoundError (box), BadInputError (no
        frames of it), LockedLabelError, HiddenLabelError.
        """
        recording = self._recording(sequence)
        drawn = self._store.boxes.get(sequence, box)
        chosen = [f for f in parse_frames(frames, len(recording)) if f in drawn.poses]
        if not chosen:
            raise BadInputError(
                f"frames: expected frames of the box, {min(drawn.poses)} to {max(drawn.poses)}, "
                f"got {frames}"
            )
        name = self._store.label(sequence, drawn.label).name
        only: Only = "unlabeled" if only_unlabeled else "any"

        def summary(points: int, frames: int) -> str:
            where = f" in {frames} frames" if frames > 1 else ""
            return f"paint {points:,} points of a box as '{name}'{where}"

        return self._store.apply(
            sequence,
            edit_id=edit_id(edit),
            author=author,
            kind="paint",
            writes=_writes(recording, drawn, chosen, only),
            summary=summary,
            identity=recording.identity,
        )


def _writes(
    recording: Recording, box: OrientedBox, frames: list[int], only: Only
) -> Iterator[tuple[int, Write]]:
    shift = np.asarray(recording.manifest.shift, np.float64)
    for frame in frames:
        pose = box.poses[frame]
        # Includes an empty write, so that a locked label is always refused.
        found = [np.empty(0, np.int64)]
        if recording[frame].count:
            place = (pose.centre - shift, box.size, rotation_of(pose.quaternion))
            found += points_in(frame_points(recording[frame]), *place)
        for numbers in found:
            yield (
                frame,
                Write(
                    numbers,
                    label=box.label,
                    provenance=PAINTED,
                    only=only,
                    living=True,
                    hidden=frozenset(),
                ),
            )
