"""Consistency of static places over frames: predictions for a training frame count in others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.classifier import Classifier
from pointbrush.classify.features import Described
from pointbrush.classify.smoothing import Chances, average_over_pieces
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.classifiers.frames import level_rotation

Floats = NDArray[np.float64]
PredictFrame = Callable[[int], tuple[Described, Chances]]
"""Returns the features of a frame and the class probabilities of its cells."""
REACH = 4.0
"""Distance, in cells, within which places of two frames are the same."""


def voter_of(
    classifier: Classifier, recording: Recording, frame: int, most_points: int
) -> int | None:
    """Return the nearest other training frame of a classifier with a pose, or None.

    ``most_points``: larger frames are processed in parts and are not used.
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


def average_chances(
    recording: Recording,
    frame: int,
    place: Described,
    chance: Chances,
    voter: int,
    predict: PredictFrame,
) -> Chances:
    """Average the chances (C, K) of cells with the same places in frame ``voter``; vote again."""
    from scipy.spatial import cKDTree  # slow to import, needed only here

    other_place, other_chances = predict(voter)
    if not (len(other_place.center) and len(place.center)):
        return chance
    T = np.linalg.inv(_world_of(recording, voter)) @ _world_of(recording, frame)
    seen = place.center.astype(np.float64) @ T[:3, :3].T + T[:3, 3]
    distances, near = cKDTree(other_place.center).query(
        seen, distance_upper_bound=REACH * place.size
    )
    same = np.flatnonzero(np.isfinite(distances))
    out = chance.copy()
    out[same] = (out[same] + other_chances[np.asarray(near)[same]]) / 2
    return average_over_pieces(out, place.piece)


def _world_of(recording: Recording, frame: int) -> Floats:
    """Return the transform (4, 4) from a frame's level coordinates to the world's."""
    to_local, shifted = np.eye(4), np.eye(4)
    to_local[:3, :3] = level_rotation(recording.manifest).T
    shifted[:3, 3] = recording.manifest.shift
    pose = np.asarray(recording.manifest.poses[frame], np.float64).reshape(4, 4)
    return np.asarray(pose @ shifted @ to_local)
