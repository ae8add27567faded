"""Questions about uncertain pieces of frames, and the points of a piece when it is answered."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.classify.classifier import Classifier
from pointbrush.classify.doubt import Doubt, doubts, two_best
from pointbrush.classify.features import Described
from pointbrush.classify.piece import piece_around
from pointbrush.classify.smoothing import Chances
from pointbrush.labels import LabelStore
from pointbrush.labels.types import PAINTED
from pointbrush.ranges import runs_of
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.classifiers import Place
from pointbrush.work.classifiers.described import DescribedFrames
from pointbrush.work.classifiers.frames import example_frame, level_rotation
from pointbrush.work.classifiers.ignoring import ignored_cells
from pointbrush.work.classifiers.options import ClassifierOptions
from pointbrush.work.classifiers.predicting import Predictor
from pointbrush.work.classifiers.teaching import cell_classes

Numbers = NDArray[np.int64]
MOST_OFFERED = 256
"""Uncertain pieces that are kept until their answer, at most."""
SPARE = 8
"""Places of a frame that are found in addition, as pieces may be too small to be asked about."""


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """A described frame, or its points ``members``, and the chances of its cells.

    ``open_`` (C,): cells without an answer.
    """

    recording: Recording
    frame: int
    place: Described
    members: Numbers
    chance: Chances
    open_: NDArray[np.bool_]


class Questions:
    """Finds uncertain pieces and remembers them until their answer; thread-safe."""

    def __init__(
        self,
        store: LabelStore,
        frames: DescribedFrames,
        predictor: Predictor,
        options: ClassifierOptions,
    ) -> None:
        self._store, self._frames = store, frames
        self._predictor, self._options = predictor, options
        self._offered: Cache[tuple[object, ...], Numbers] = Cache(MOST_OFFERED)
        """Stored numbers of the pieces in questions, by import, frame and centre."""

    def of_frame(
        self, classifier: Classifier, recording: Recording, frame: int,
        near: Sequence[float] | None, most: int, between: Sequence[str],
    ) -> list[tuple[float, Callable[[], Place | None]]]:  # fmt: skip
        """Return the worth of answers at places of a frame, each with a function that makes it.

        The function returns None if no piece there is large enough.
        """
        view = self._view(classifier, recording, frame, near)
        open_ = view.open_
        if between:
            wanted = np.isin(classifier.classes, list(between))
            open_ = open_ & wanted[two_best(view.chance)].all(axis=1)
        taught = classifier.taught(self._options.forest.most)[0]
        options = self._options.doubt
        found = doubts(
            view.place, view.chance, open_, taught, classifier.spread, options, most + SPARE
        )
        return [(each.worth, partial(self._place, classifier, view, each)) for each in found]

    def _view(
        self, classifier: Classifier, recording: Recording, frame: int,
        near: Sequence[float] | None,
    ) -> _View:  # fmt: skip
        """Predict a frame, or its points ``near`` a place (3,), source metres."""
        stored = recording[frame]
        size = self._predictor.size(classifier, recording, frame)
        middle = np.asarray(stored.coordinates[np.arange(1)], np.float64)[0]
        if near is not None:
            middle = np.asarray(near, np.float64) - np.asarray(recording.manifest.shift)
        place, members = self._frames.round(recording, frame, size, middle)
        values = self._store.values(recording.manifest.id, frame)
        painted = ((values.provenance == PAINTED) | values.deleted)[members]
        done = cell_classes(place, painted.astype(np.uint8)) > 0
        done |= ignored_cells(classifier, recording, frame, place, members, skipped=True)
        chance = self._predictor.chances(classifier, recording, frame, place, members)
        return _View(recording, frame, place, members, chance, ~done)

    def _piece(self, view: _View, cell: int) -> Numbers:
        """Return stored numbers (n,), ascending, of the piece around a cell."""
        best = view.chance.argmax(axis=1)
        open_ = view.open_ & (best == best[cell])
        open_[cell] = True
        points = view.recording, view.frame, view.members
        return np.sort(view.members[
            piece_around(
                view.place, cell, open_,
                lambda some: example_frame(*points[:2], points[2][some]),
                self._options.doubt,
            )
        ])  # fmt: skip

    def _place(self, classifier: Classifier, view: _View, doubt: Doubt) -> Place | None:
        recording, manifest = view.recording, view.recording.manifest
        piece = self._piece(view, doubt.cell)
        if not len(piece):
            return None
        cell = view.place.center[doubt.cell].astype(np.float64) @ level_rotation(manifest)
        points = recording[view.frame].coordinates[piece].astype(np.float64)
        middle = points[np.linalg.norm(points - cell, axis=1).argmin()]
        distances = np.linalg.norm(points - middle, axis=1)
        x, y, z = (middle + np.asarray(manifest.shift)).tolist()
        self._offered.put((recording.identity, view.frame, x, y, z), piece)
        first, second = (classifier.classes[each] for each in doubt.classes)
        return Place(
            manifest.id, view.frame, (x, y, z),
            max(float(np.median(distances)), view.place.size / 2),
            len(piece), tuple(map(tuple, runs_of(piece).tolist())), (first, second), doubt.doubt,
        )  # fmt: skip

    def piece_of(
        self, classifier: Classifier, recording: Recording, frame: int, centre: Sequence[float]
    ) -> Numbers:
        """Return the piece of a question; a forgotten one is found again."""
        known = self._offered.known((recording.identity, frame, *centre))
        if known is not None:
            return known
        view = self._view(classifier, recording, frame, centre)
        level, shift = level_rotation(recording.manifest), np.asarray(recording.manifest.shift)
        offsets = view.place.center - level @ (np.asarray(centre) - shift)
        return self._piece(view, int(np.linalg.norm(offsets, axis=1).argmin()))
