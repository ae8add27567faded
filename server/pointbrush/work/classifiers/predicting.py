"""Prediction of a frame by a classifier."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.classifier import Classifier
from pointbrush.classify.doubt import confusions
from pointbrush.classify.features import Described
from pointbrush.classify.models import Model, Models
from pointbrush.classify.smoothing import Chances, point_classes
from pointbrush.errors import BadInputError
from pointbrush.labels import LabelStore
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.classifiers.agreeing import average_chances, voter_of
from pointbrush.work.classifiers.described import DescribedFrames
from pointbrush.work.classifiers.frames import example_frame
from pointbrush.work.classifiers.ignoring import ignored_cells
from pointbrush.work.classifiers.naming import label_of
from pointbrush.work.classifiers.options import ClassifierOptions

Numbers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """Classes of points of a frame by a classifier, in stored order.

    ``numbers`` (n,) of the points, or None: all; ``label`` (n,) uint16, 0 if the palette has no
    label of the class; ``kind`` (n,) uint8 class from 1, 0 if the classifier is untrained;
    ``confidence`` (n,) uint8.
    """

    numbers: Numbers | None
    label: NDArray[np.uint16]
    kind: NDArray[np.uint8]
    confidence: NDArray[np.uint8]
    classes: tuple[str, ...]
    labels: tuple[int, ...]
    """Label ids of the classes, 0 for none."""
    confused: NDArray[np.int64]
    """Points (K, K) in doubt between two classes, the first one lower."""
    doubts: NDArray[np.int64]
    """Places in doubt (K,) of each class."""


class Predictor:
    """Predicts frames; thread-safe.  ``models``: models available instead of trees."""

    def __init__(
        self, store: LabelStore, frames: DescribedFrames, models: Models, options: ClassifierOptions
    ) -> None:
        self._store, self._frames = store, frames
        self._models, self._options = models, options
        self._voting: tuple[tuple[Classifier, str, int], Described, Chances] | None = None

    def predict(
        self, classifier: Classifier, recording: Recording, frame: int,
        labels: Sequence[int] | None, place: Sequence[float] | None,
    ) -> Prediction:  # fmt: skip
        """Predict the classes of a frame's points, as ``Classifiers.predict``."""
        numbers: Numbers | None = None
        size = self.size(classifier, recording, frame)
        if place is None:
            described = self._frames.whole(recording, frame, size)
        else:
            at = np.asarray(place, np.float64) - np.asarray(recording.manifest.shift)
            described, found = self._frames.round(recording, frame, size, at)
            numbers = found if len(found) < recording[frame].count else None
        chances = self.chances(classifier, recording, frame, described, numbers)
        ids = self._label_ids(recording.manifest.id, classifier)
        if labels is not None:
            chances = _only(chances, np.isin(ids[1:], list(labels)))
        kind, sure = point_classes(chances, described.of_point)
        if not classifier.ready:
            kind, sure = np.zeros_like(kind), np.zeros_like(sure)
        ignored = ignored_cells(classifier, recording, frame, described, numbers)
        confused, left = confusions(described, chances, ~ignored, self._options.doubt)
        ignored = ignored[described.of_point]
        kind[ignored], sure[ignored] = 0, 0
        named = tuple(ids[1:].tolist())
        return Prediction(numbers, ids[kind], kind, sure, classifier.classes, named, confused, left)

    def chances(
        self, classifier: Classifier, recording: Recording, frame: int, place: Described,
        members: Numbers | None,
    ) -> Chances:  # fmt: skip
        """Return a classifier's chances for a frame, or for its points ``members``."""
        points = partial(example_frame, recording, frame, members)
        chance = classifier.chances(place, points, self.model(classifier))
        voter = voter_of(classifier, recording, frame, self._options.whole_points)
        if voter is None:
            return chance
        predict = partial(self._compared, classifier, recording)
        return average_chances(recording, frame, place, chance, voter, predict)

    def _compared(
        self, classifier: Classifier, recording: Recording, frame: int
    ) -> tuple[Described, Chances]:
        """Return the prediction for a frame that others are compared with; cached."""
        key = (classifier, recording.placement, frame)
        known = self._voting
        if known is None or known[0] != key:
            place = self._frames.whole(recording, frame, classifier.size)
            chance = classifier.chances(place, partial(example_frame, recording, frame))
            known = self._voting = key, place, chance
        return known[1], known[2]

    def model(self, classifier: Classifier) -> Model | None:
        """Return the model that predicts in place of the trees; None: there is none."""
        return self._models.make(classifier.model) if classifier.model else None

    def size(self, classifier: Classifier, recording: Recording, frame: int) -> float:
        """Return the edge of a cell, metres."""
        return classifier.size or self._frames.scale(recording, frame)

    def _label_ids(self, sequence: str, classifier: Classifier) -> NDArray[np.uint16]:
        """Return the label ids (K + 1,) of classes from 1; 0: no label."""
        palette = self._store.palette(sequence)
        found = [label_of(name, palette) for name in classifier.classes]
        return np.array([0, *(0 if each is None else each.id for each in found)], np.uint16)


def _only(chances: Chances, wanted: NDArray[np.bool_]) -> Chances:
    """Return the renormalized chances (C, K) of the classes ``wanted`` (K,)."""
    if not wanted.any():
        raise BadInputError("labels: expected at least one of a class of the classifier")
    kept = chances * wanted
    return np.asarray(kept / np.maximum(kept.sum(axis=1, keepdims=True), 1e-9), np.float32)
