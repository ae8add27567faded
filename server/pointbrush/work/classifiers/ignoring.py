"""Places that a person answered with "none of these", excluded from questions and predictions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.classifier import Classifier, Ignored
from pointbrush.classify.features import Described
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.classifiers.frames import level_rotation


def ignored_cells(
    classifier: Classifier, recording: Recording, frame: int, place: Described
) -> NDArray[np.bool_]:
    """Return whether each cell (C,) of a described frame lies in an ignored place."""
    found = np.zeros(len(place.center), bool)
    level = level_rotation(recording.manifest)
    for each in _of(classifier, recording, frame):
        away = place.center - level @ np.asarray(each.centre)
        found |= np.linalg.norm(away, axis=1) <= each.radius
    return found


def _of(classifier: Classifier, recording: Recording, frame: int) -> list[Ignored]:
    here = recording.identity, frame
    return [each for each in classifier.ignored if (each.identity, each.frame) == here]
