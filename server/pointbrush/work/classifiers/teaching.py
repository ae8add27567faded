"""Examples of a classifier from painted or imported points of recordings."""

from __future__ import annotations

import hashlib
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.classify.classifier import Classifier, Examples, balanced
from pointbrush.classify.features import Described
from pointbrush.classify.grid import connected, neighbours, number_cubes
from pointbrush.labels import LabelStore
from pointbrush.labels.types import IMPORTED, PAINTED
from pointbrush.ranges import evenly_spaced
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.classifiers.described import DescribedFrames, Part
from pointbrush.work.classifiers.naming import numbers_of
from pointbrush.work.classifiers.options import ClassifierOptions

PLACE = 8.0
"""Edge of a cube, cells; examples in neighbouring cubes are one place, held out together."""
LARGEST_PLACE = 48.0
"""Extent of a place, cells; larger places are cut into cubes of this edge."""
EARLIER_FRAMES = 4
"""Frames of a recording that teach as earlier work, evenly spaced."""
Key = tuple[str, int]
Taken = tuple[NDArray[np.float32], NDArray[np.uint8], NDArray[np.int64], NDArray[np.float64]]
"""Features, classes from 0 and places of training cells, and the spread of the part's features."""


class Teacher:
    """Collects training examples of a classifier from recordings."""

    def __init__(
        self, store: LabelStore, frames: DescribedFrames, options: ClassifierOptions
    ) -> None:
        self._store, self._frames, self._options = store, frames, options
        self._bring: dict[Key, tuple[int, bool]] = {}
        self._parts: Cache[Hashable, Taken] = Cache(options.memory_bytes // 4)

    def fresh(
        self, classifier: Classifier, recordings: Mapping[str, Recording],
        earlier: Mapping[str, Recording],
    ) -> Classifier:  # fmt: skip
        """Return a classifier with current examples, or ``classifier`` itself without changes.

        ``recordings``: its training recordings in this workspace; other examples are kept.
        ``earlier``: recordings of earlier work, which are read once.
        """
        examples = {
            key: some
            for key, some in classifier.examples.items()
            if not _is_of(some, recordings.get(key[0]))
        }
        size = classifier.size
        for recording in recordings.values():
            for frame in self._painted(recording, classifier):
                size = size or self._frames.scale(recording, frame)
                examples[recording.manifest.id, frame] = self._examples(
                    replace(classifier, size=size), recording, frame
                )
        known = {recording for recording, _ in examples}
        for name in earlier.keys() - known - recordings.keys():
            for frame in self.labelled(earlier[name], classifier.classes):
                size = size or self._frames.scale(earlier[name], frame)
                begun = replace(classifier, size=size, imported=True)
                examples[name, frame] = self._examples(begun, earlier[name], frame)
        if size == classifier.size and _same(examples, classifier.examples):
            return classifier
        return replace(classifier, size=size, examples=examples)

    def _painted(self, recording: Recording, classifier: Classifier) -> list[int]:
        """Return the training frames of its classes, evenly spaced above the limit."""
        sequence = recording.manifest.id
        table = numbers_of(self._store.palette(sequence), classifier.classes)
        by_hand: dict[int, bool] = {}
        for (frame, label), (_, painted) in self._store.counts(sequence).items():
            if table[label]:
                by_hand[frame] = by_hand.get(frame, False) or painted > 0
        found = sorted(
            frame
            for frame, painted in by_hand.items()
            if painted or (classifier.imported and self._has_imported(sequence, frame))
        )
        return [found[k] for k in evenly_spaced(len(found), self._options.taught_frames)]

    def labelled(self, recording: Recording, classes: Sequence[str]) -> list[int]:
        """Return some frames with painted or imported labels of the classes."""
        wanted = Classifier("", tuple(classes), imported=True)
        found = self._painted(recording, wanted)
        return [found[k] for k in evenly_spaced(len(found), EARLIER_FRAMES)]

    def _has_imported(self, sequence: str, frame: int) -> bool:
        """Return whether a frame has imported labels; cached until the frame changes."""
        changed = self._store.changed(sequence, frame)
        known = self._bring.get((sequence, frame))
        if known is None or known[0] != changed:
            values = self._store.values(sequence, frame)
            known = changed, bool((values.provenance == IMPORTED).any())
            self._bring[sequence, frame] = known
        return known[1]

    def _examples(self, classifier: Classifier, recording: Recording, frame: int) -> Examples:
        sequence = recording.manifest.id
        known = classifier.examples.get((sequence, frame))
        changed = self._store.changed(sequence, frame)
        if known is not None and (known.identity, known.revision) == (
            recording.identity, changed,
        ):  # fmt: skip
            return known
        # The revision is read first: newer values are then read again at the next call.
        table = numbers_of(self._store.palette(sequence), classifier.classes)
        values = self._store.values(sequence, frame)
        teaches = values.provenance == PAINTED
        if classifier.imported:
            teaches |= values.provenance == IMPORTED
        kind = np.where(teaches & ~values.deleted, table[values.label], 0)
        painted = np.flatnonzero(kind)
        found = self._frames.holding(recording, frame, classifier.size, painted)
        parts = [self._taken(part, kind) for part in islice(found, self._options.taught_places)]
        spread = np.mean([part[3] for part in parts], axis=0)
        features, classes = (np.concatenate([part[k] for part in parts]) for k in range(2))
        places = np.concatenate([part[2] * len(parts) + k for k, part in enumerate(parts)])
        return Examples(features, classes, places, spread, recording.identity, changed)

    def _taken(self, part: Part, kind: NDArray[np.uint8]) -> Taken:
        """Return the training cells of a part; cached until its labels change."""
        own = kind[part.members]
        key = part.key, hashlib.blake2b(own.tobytes()).digest()
        known = self._parts.known(key)
        if known is None:
            known = _taken(part.describe(), own, self._options.frame_examples)
            kept = known
            self._parts.get(key, lambda: kept, sum(each.nbytes for each in known))
        return known


def _is_of(some: Examples, recording: Recording | None) -> bool:
    return recording is not None and some.identity == recording.identity


def _same(one: Mapping[Key, Examples], other: Mapping[Key, Examples]) -> bool:
    return one.keys() == other.keys() and all(one[key] is other[key] for key in one)


def _taken(place: Described, kind: NDArray[np.uint8], most: int) -> Taken:
    """Return training cells: features, classes from 0, places, and the features' spread."""
    of_cell = cell_classes(place, kind)
    cells = np.flatnonzero(of_cell)
    cells = cells[balanced(of_cell[cells].astype(np.int64), most)]
    spread = place.features.std(axis=0, dtype=np.float64)
    where = _places(place.center[cells].astype(np.float64), place.size)
    return place.features[cells], of_cell[cells] - 1, where, spread


def _places(center: NDArray[np.float64], size: float) -> NDArray[np.int64]:
    """Return the place (n,) of each of the examples (n, 3): a group of strokes, or a part of it."""
    if not len(center):
        return np.zeros(0, np.int64)
    center = center - center.min(axis=0)
    cube, keys, slots = number_cubes(center, np.zeros(3), PLACE * size)
    group = connected(neighbours(keys, slots))[cube]
    low, high = (np.full((len(keys), 3), value) for value in (np.inf, -np.inf))
    np.minimum.at(low, group, center)
    np.maximum.at(high, group, center)
    part = np.floor(center / (LARGEST_PLACE * size)).astype(np.int64)
    part[((high - low)[group] <= LARGEST_PLACE * size).all(axis=1)] = 0
    rows = np.column_stack([group, part])
    return np.unique(rows, axis=0, return_inverse=True)[1].ravel().astype(np.int64)


def cell_classes(place: Described, kind: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the most frequent class (C,) of a cell's labelled points; 0: none."""
    labelled = np.flatnonzero(kind)
    if not len(labelled):
        return np.zeros(len(place.center), np.uint8)
    width = int(kind.max()) + 1
    key = place.of_point[labelled].astype(np.int64) * width + kind[labelled]
    keys, counts = np.unique(key, return_counts=True)
    out = np.zeros(len(place.center), np.uint8)
    order = np.argsort(counts, kind="stable")  # the most frequent class is written last
    out[keys[order] // width] = (keys[order] % width).astype(np.uint8)
    return out
