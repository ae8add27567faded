"""Places that stand still agree over frames: what is said of a taught frame counts in others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.classifier import Classifier
from pointbrush.classify.features import Described
from pointbrush.classify.smoothing import Chances, voted
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.classifiers.frames import level_rotation

Floats = NDArray[np.float64]
Say = Callable[[int], tuple[Described, Chances]]
"""Describes a frame, and says the chances of its cells."""
REACH = 4.0
"""Cells within which a place of another frame is the same one."""


def voter_of(
    classifier: Classifier, recording: Recording, frame: int, most_points: int
) -> int | None:
    """Return the nearest other frame that taught a classifier, if poses lead to it; or None.

    ``most_points``: larger frames are described in parts and do not vote.
    """
    sequence, poses = recording.manifest.id, recording.manifest.poses
    if classifier.model or poses[frame] is None or recording[frame].count > most_points:
        return None
    able = [
        other
        for name, other in classifier.examples
        if name == sequence and other != frame and other < len(recording)
        and poses[other] is not None and recording[other].count <= most_points
    ]  # fmt: skip
    return min(able, key=lambda other: abs(other - frame), default=None)


def agreed(
    recording: Recording, frame: int, place: Described, chance: Chances, voter: int, say: Say
) -> Chances:
    """Mean the chances (C, K) of a frame's cells with the same places' there, and vote again."""
    from scipy.spatial import cKDTree  # loads much that no other call needs

    there, said = say(voter)
    if not (len(there.center) and len(place.center)):
        return chance
    T = np.linalg.inv(_world_of(recording, voter)) @ _world_of(recording, frame)
    seen = place.center.astype(np.float64) @ T[:3, :3].T + T[:3, 3]
    away, near = cKDTree(there.center).query(seen, distance_upper_bound=REACH * place.size)
    same = np.flatnonzero(np.isfinite(away))
    out = chance.copy()
    out[same] = (out[same] + said[np.asarray(near)[same]]) / 2
    return voted(out, place.groups)


def _world_of(recording: Recording, frame: int) -> Floats:
    """Return the transform (4, 4) from a frame's level coordinates to the world's."""
    to_local, shifted = np.eye(4), np.eye(4)
    to_local[:3, :3] = level_rotation(recording.manifest).T
    shifted[:3, 3] = recording.manifest.shift
    pose = np.asarray(recording.manifest.poses[frame], np.float64).reshape(4, 4)
    return np.asarray(pose @ shifted @ to_local)
