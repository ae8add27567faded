"""Places that a person answered with "none of these" or skipped."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.classifier import Classifier, Ignored
from pointbrush.classify.features import Described
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.classifiers.frames import level_rotation

Numbers = NDArray[np.int64]


def ignored_cells(
    classifier: Classifier, recording: Recording, frame: int, place: Described,
    members: Numbers | None, *, skipped: bool = False,
) -> NDArray[np.bool_]:  # fmt: skip
    """Return whether each cell (C,) of a described frame is ignored.

    ``members``: stored numbers of the described points, None: all; ``skipped``: also the cells of
    places that were skipped.
    """
    found = np.zeros(len(place.center), bool)
    level = level_rotation(recording.manifest)
    key = recording.identity, frame
    places = [each for each in classifier.ignored if (each.identity, each.frame) == key]
    for each in places if skipped else [each for each in places if not each.skipped]:
        if each.runs:
            points = _points_of(each, recording[frame].count)
            found[place.of_point[points if members is None else points[members]]] = True
        else:
            offsets = place.center - level @ np.asarray(each.centre)
            found |= np.linalg.norm(offsets, axis=1) <= each.radius
    return found


def _points_of(place: Ignored, count: int) -> NDArray[np.bool_]:
    """Return whether each point (N,) of a frame is in the runs of an ignored place."""
    found = np.zeros(count, bool)
    for start, length in place.runs:
        found[max(start, 0) : max(start + length, 0)] = True
    return found
