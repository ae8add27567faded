"""Placement of overlaid frames by the recording's poses and by tracks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.labels import LabelStore
from pointbrush.selection.rigid import inverse, translation
from pointbrush.sequences import Sequence as Recording

Matrix = NDArray[np.float64]
UNKNOWN = "lost"
"""State of a track without a known pose."""


@dataclass(frozen=True, eq=False)
class Placement:
    """Placement of one frame over the shown frame.

    ``T_shown_frame`` (4, 4) from its local coordinates to the shown frame's; ``moving``: the same
    by label, for labels with tracks that give their motion between the two frames.
    """

    frame: int
    T_shown_frame: Matrix
    moving: Mapping[int, Matrix] = field(default_factory=dict)


def require_overlaid(recording: Recording, frame: int, others: Iterable[int]) -> None:
    """Raise BadInputError if ``others`` cannot be overlaid, as the frames are octrees."""
    if recording.manifest.large and set(others) - {frame}:
        name = recording.manifest.id
        raise BadInputError(
            f"frames: expected a recording whose frames are in one piece, '{name}' "
            "stores them as octrees: show and paint its frames one by one"
        )


def placements(
    store: LabelStore, recording: Recording, shown: int, frames: Iterable[int]
) -> list[Placement]:
    """Return placements of ``frames`` over frame ``shown``; its own placement is first.

    Without poses, all frames have the same coordinates.  Raises NotFoundError (a frame),
    BadInputError (only some frames have a pose).
    """
    others = sorted(set(frames) - {shown})
    for frame in (shown, *others):
        if not 0 <= frame < len(recording):
            raise NotFoundError(
                f"frames: expected frames 0 to {len(recording) - 1}, got {str(frame)[:20]}"
            )
    if not others:
        return [Placement(shown, np.eye(4))]
    tracks = _Tracks(store.tracks(recording.manifest.id))
    placed = [Placement(shown, np.eye(4))]
    for frame in others:
        T = _by_poses(recording, shown, frame)
        placed.append(Placement(frame, T, tracks.between(shown, frame)))
    return placed


def placements_round(
    store: LabelStore, recording: Recording, frame: int, before: int, after: int
) -> list[Placement]:
    """Return placements of ``frame``, up to ``before`` frames before and ``after`` after it."""
    _ = recording[frame]
    frames = range(max(0, frame - before), min(len(recording), frame + after + 1))
    require_overlaid(recording, frame, frames)
    return placements(store, recording, frame, frames)


def _by_poses(recording: Recording, shown: int, frame: int) -> Matrix:
    """Return ``T_shown_frame`` in local coordinates for static points."""
    manifest = recording.manifest
    if all(pose is None for pose in manifest.poses):
        return np.eye(4)
    world = []
    for number in (shown, frame):
        pose = manifest.poses[number]
        if pose is None:
            raise BadInputError(f"frames: expected frames with a pose, frame {number} has none")
        world.append(np.asarray(pose, np.float64).reshape(4, 4))
    shift = np.asarray(manifest.shift, np.float64)
    T_shown_frame = np.linalg.inv(world[0]) @ world[1]
    return np.asarray(translation(-shift) @ T_shown_frame @ translation(shift))


class _Tracks:
    """Known poses ``T_frame_start`` of tracks by frame and label."""

    def __init__(self, tracks: Iterable[Mapping[str, Any]]) -> None:
        self._rows: dict[int, dict[int, Mapping[str, Any]]] = {}
        for row in tracks:
            if row.get("state") != UNKNOWN and row.get("pose") is not None:
                self._rows.setdefault(int(row["frame"]), {})[int(row["label"])] = row

    def between(self, shown: int, frame: int) -> dict[int, Matrix]:
        """Return ``T_shown_frame`` by label, for labels with poses of one run in both frames."""
        shown_rows, frame_rows = self._rows.get(shown, {}), self._rows.get(frame, {})
        found = {}
        for label in shown_rows.keys() | frame_rows.keys():
            start = (shown_rows.get(label) or frame_rows[label]).get("start")
            T_shown_start = _pose(shown_rows.get(label), shown, start)
            T_frame_start = _pose(frame_rows.get(label), frame, start)
            if T_shown_start is not None and T_frame_start is not None:
                found[label] = T_shown_start @ inverse(T_frame_start)
        return found


def _pose(row: Mapping[str, Any] | None, frame: int, start: object) -> Matrix | None:
    """Return ``T_frame_start`` of a row of the run that began at ``start``, or None."""
    if row is None:
        return np.eye(4) if frame == start else None
    if row.get("start") != start:
        return None
    return np.asarray(row["pose"], np.float64).reshape(4, 4)
