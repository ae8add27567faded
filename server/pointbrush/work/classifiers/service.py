"""The classifiers of a workspace: creation, training, prediction and deletion."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.classifier import (
    Classifier,
    Ignored,
    check_classes,
    check_name,
    from_file,
    to_file,
)
from pointbrush.classify.models import BUILT_IN, Models
from pointbrush.classify.options import MOST_IGNORED
from pointbrush.classify.smoothing import Chances
from pointbrush.database.class_names import ClassNames
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.labels import Commit, LabelStore, Write
from pointbrush.labels.types import PAINTED
from pointbrush.ranges import evenly_spaced, runs_of
from pointbrush.sequences import Sequence as Recording
from pointbrush.values import classifiers as values
from pointbrush.values.classifiers import HeldOut, Place, Start
from pointbrush.work.classifiers.asking import Questions
from pointbrush.work.classifiers.described import DescribedFrames
from pointbrush.work.classifiers.files import ClassifierFiles
from pointbrush.work.classifiers.naming import classes_of
from pointbrush.work.classifiers.options import ClassifierOptions
from pointbrush.work.classifiers.predicting import Prediction, Predictor
from pointbrush.work.classifiers.teaching import Teacher

Numbers = NDArray[np.int64]
SCORED_FRAMES = 3
"""Frames in which the accuracy is expected, evenly chosen."""
SCORED_POINTS = 2_000
"""Points of such a frame, evenly chosen in stored order."""
FEWEST_CLASSES = 2
"""Classes of a recording from which others can start."""


class Classifiers:
    """The classifiers in ``folder``; thread-safe."""

    def __init__(
        self,
        store: LabelStore,
        folder: Path,
        recording: Callable[[str], Recording],
        recordings: Callable[[], Sequence[str]],
        options: ClassifierOptions | None = None,
        models: Models | None = None,
    ) -> None:
        """``recording`` opens a recording by its id; ``recordings`` lists the ids.

        ``models``: models available instead of trees.
        """
        self.models = models or Models()
        self.options = options or ClassifierOptions()
        self._store, self._recording, self._recordings = store, recording, recordings
        self._files = ClassifierFiles(folder)
        self._frames = DescribedFrames(self.options)
        self._teacher = Teacher(store, self._frames, self.options)
        self._predictor = Predictor(store, self._frames, self.models, self.options)
        self._questions = Questions(store, self._frames, self._predictor, self.options)
        self._known: dict[str, tuple[ClassNames, Classifier]] = {}
        """Classifiers by id, each with the class names at the time it was read."""
        self._locks: dict[str, threading.RLock] = {}
        self._lock = threading.Lock()

    # ── management ───────────────────────────────────────────────────────────────────────

    def listing(self) -> list[values.Classifier]:
        """Return all classifiers, by id; unreadable files are left out."""
        found = []
        for identifier in self._files.ids():
            try:
                found.append(self.about(identifier))
            except (BadInputError, NotFoundError):
                continue
        return found

    def about(self, identifier: str) -> values.Classifier:
        """Return the description of a classifier; raises NotFoundError."""
        return _about(identifier, self._read(identifier)[1])

    def create(
        self, name: str, recordings: Sequence[str], classes: Sequence[str] | None = None,
        model: str = BUILT_IN, imported: bool = False, start_from: Sequence[str] = (),
    ) -> values.Classifier:  # fmt: skip
        """Create a classifier, trained on painted points of recordings.

        ``classes``: by default the model's, or all of the recordings' palettes; ``model``: name of
        a model instead of trees; ``imported``: also train on imported labels; ``start_from``:
        recordings whose painted and imported labels count less, the more is painted here.  Raises
        BadInputError, NotFoundError (a recording), UnavailableError (the model).
        """
        self._require_writable()
        if not recordings:
            raise BadInputError("recordings: expected at least one, got none")
        if classes is None and model:
            classes = self.models.make(model).classes or None
        if classes is None:
            every = map(self._checked, [*recordings, *start_from])
            palettes = [self._store.palette(each) for each in every]
            classes = list(dict.fromkeys(name for one in palettes for name in classes_of(one)))
        first = self._recording(recordings[0])
        size = self._frames.scale(first, 0) if model else 0.0  # 0: from painted points
        made = Classifier(
            check_name(name), check_classes(list(classes)), size, model=model, imported=imported,
            start_from=tuple(map(self._checked, start_from)),
        )  # fmt: skip
        with self._lock:
            identifier = self._files.free_id(name)
            self._write(identifier, made, self._store.class_names())
        return self.teach(identifier, recordings)

    def teach(self, identifier: str, recordings: Sequence[str] = ()) -> values.Classifier:
        """Train on the current painted points, also of ``recordings``, and store the result."""
        self._require_writable()
        for each in recordings:
            self._checked(each)
        with self._guard(identifier):
            names, fresh = self._fresh(identifier, recordings)
            taught = fresh.scored(self.options.forest, *self._sample(fresh))
            self._known[identifier] = names, taught
            self._write(identifier, taught, names)
        return _about(identifier, taught)

    def _sample(self, classifier: Classifier) -> tuple[NDArray[np.float32], Chances]:
        """Return features (n, F) and chances (n, K) of points of some training frames."""
        recordings = self._opened(classifier.recordings)
        frames = [
            (recordings[name], frame)
            for name, frame in classifier.examples
            if name in recordings and frame < len(recordings[name])
        ]
        features = [np.zeros((0, len(classifier.spread)), np.float32)]
        chances = [np.zeros((0, len(classifier.classes)), np.float32)]
        for k in evenly_spaced(len(frames), SCORED_FRAMES):
            recording, frame = frames[k]
            middle = np.array([recording[frame].count // 2])
            part = next(self._frames.holding(recording, frame, classifier.size, middle))
            place = part.describe()
            chance = self._predictor.chances(classifier, recording, frame, place, part.members)
            cells = place.of_point[evenly_spaced(len(place.of_point), SCORED_POINTS)]
            features.append(place.features[cells])
            chances.append(chance[cells])
        return np.concatenate(features), np.concatenate(chances)

    def starts(self, sequence: str) -> list[Start]:
        """Return the recordings that a classifier of a recording can start from.

        They have labels of two or more classes, of the recording's if it has any.
        """
        own = set(classes_of(self._store.palette(self._checked(sequence))))
        found = []
        for name in self._recordings():
            classes = classes_of(self._store.palette(name))
            shared = tuple(each for each in classes if not own or each in own)
            able = name != sequence and len(shared) >= FEWEST_CLASSES
            if able and self._teacher.labelled(self._recording(name), shared):
                found.append(Start(name, shared))
        return found

    def delete(self, identifier: str) -> None:
        """Delete a classifier; its predictions are kept.  Raises NotFoundError."""
        self._require_writable()
        with self._guard(identifier):
            self._files.delete(identifier)
            self._known.pop(identifier, None)
        with self._lock:
            self._locks.pop(identifier, None)

    def file(self, identifier: str) -> bytes:
        """Return the bytes of a classifier's current file, without ignored places."""
        return to_file(replace(self._read(identifier)[1], ignored=()))

    def import_file(self, data: bytes, name: str | None = None) -> values.Classifier:
        """Import a classifier's file; raises BadInputError for an invalid file."""
        self._require_writable()
        given, names = from_file(data), self._store.class_names()
        given = given.called([names.meaning(word) for word in given.classes])
        if name is not None:
            given = replace(given, name=check_name(name))
        with self._lock:
            identifier = self._files.free_id(given.name)
            self._write(identifier, given, names)
        return _about(identifier, given)

    def forget_features(self, sequence: str) -> None:
        """Drop the cached features of a recording's frames."""
        self._frames.forget(self._recording(sequence).identity)

    # ── prediction ───────────────────────────────────────────────────────────────────────

    def current(self, identifier: str) -> Classifier:
        """Return a classifier trained on all current painted points of its recordings."""
        with self._guard(identifier):
            return self._fresh(identifier, ())[1]

    def predict(
        self, identifier: str, sequence: str, frame: int, *, labels: Sequence[int] | None = None,
        place: Sequence[float] | None = None,
    ) -> Prediction:  # fmt: skip
        """Predict the classes of a frame's points; nothing is changed.

        ``labels``: predict only these, by id; ``place``: only points near it, (3,) source metres,
        required for a frame that is too large to process whole.  Raises NotFoundError,
        BadInputError, TooLargeError.
        """
        recording = self._recording(sequence)
        _ = recording[frame]
        return self._predictor.predict(self.current(identifier), recording, frame, labels, place)

    # ── doubt ────────────────────────────────────────────────────────────────────────────

    def doubt(
        self, identifier: str, sequence: str, *, frame: int | None = None, workspace: bool = False,
        near: Sequence[float] | None = None, most: int = 5, between: Sequence[str] = (),
    ) -> list[Place]:  # fmt: skip
        """Return the most informative places for an answer, best first.

        The search covers one ``frame``, several frames of the recording, or several recordings of
        the workspace.  ``near`` (3,), source metres: centre of the search in a large frame of the
        recording.  ``between``: only places in doubt between these classes.
        """
        classifier, questions = self.current(identifier), self._questions
        names = [sequence]
        if workspace:
            others = [each for each in self._recordings() if each != sequence]
            names += others[: self.options.looked_recordings - 1]
        found: list[tuple[float, Callable[[], Place | None]]] = []
        for name in names:
            recording = self._recording(name)
            count = len(recording)
            frames = [frame] if frame is not None and name == sequence else evenly_spaced(
                count, self.options.looked_frames if not workspace else 2
            )  # fmt: skip
            for each in frames:
                if recording[each].count:
                    at = near if name == sequence else None
                    found += questions.of_frame(classifier, recording, each, at, most, between)
        found.sort(key=lambda each: -each[0])
        return list(islice(filter(None, (make() for _, make in found)), most))

    def answer(
        self, identifier: str, sequence: str, frame: int, centre: Sequence[float], label: int, *,
        author: str,
    ) -> Commit:  # fmt: skip
        """Answer a doubt with a label: paint its piece, as one edit.

        Only points without a label change, and predicted ones.  ``centre`` (3,) as ``doubt`` has
        it.  Raises NotFoundError, LockedLabelError, HiddenLabelError.
        """
        recording = self._recording(sequence)
        _ = recording[frame]
        self._store.require_paintable(sequence, label, frozenset())
        piece = self._questions.piece_of(self.current(identifier), recording, frame, centre)
        write = Write(
            piece, label=label, provenance=PAINTED, only="predictable", living=True,
            hidden=frozenset(),
        )  # fmt: skip
        return self._store.apply(
            sequence, edit_id=None, author=author, kind="paint", writes=[(frame, write)],
            summary=f"answered a doubt of {len(piece):,} points", identity=recording.identity,
        )  # fmt: skip

    def ignore(
        self, identifier: str, sequence: str, frame: int, centre: Sequence[float], radius: float, *,
        skipped: bool = False,
    ) -> None:  # fmt: skip
        """Answer an uncertain place with none of the classes: ignore its piece from now on.

        ``skipped``: predict the piece, but do not ask about it.  ``centre`` (3,) and ``radius``:
        source metres, as ``doubt`` returns them.  Raises NotFoundError, and BadInputError if the
        classifier ignores too many places.
        """
        recording = self._recording(sequence)
        _ = recording[frame]
        piece = self._questions.piece_of(self.current(identifier), recording, frame, centre)
        runs = tuple((start, length) for start, length in runs_of(piece).tolist())
        at = _local(recording, centre)
        place = Ignored(recording.identity, frame, at, radius, runs, skipped)
        self._set_ignored(identifier, lambda known: (*known, place))

    def undo_ignore(
        self, identifier: str, sequence: str, centre: Sequence[float] | None = None
    ) -> None:
        """Undo the last ``ignore`` in a recording, or at ``centre`` (3,); raises NotFoundError."""
        recording = self._recording(sequence)
        at = None if centre is None else _local(recording, centre)

        def without_last(known: tuple[Ignored, ...]) -> tuple[Ignored, ...]:
            mine = (each for each in known if each.identity == recording.identity)
            candidates = [each for each in mine if at in (None, each.centre)]
            if not candidates:
                raise NotFoundError("answer: expected an ignored place in this recording, got none")
            return tuple(each for each in known if each is not candidates[-1])

        self._set_ignored(identifier, without_last)

    def _set_ignored(
        self, identifier: str, change: Callable[[tuple[Ignored, ...]], tuple[Ignored, ...]]
    ) -> None:
        self._require_writable()
        with self._guard(identifier):
            names, known = self._read(identifier)
            ignored = change(known.ignored)
            if len(ignored) > MOST_IGNORED:
                raise BadInputError(f"answers: expected at most {MOST_IGNORED} ignored places")
            changed = replace(known, ignored=ignored)
            self._known[identifier] = names, changed
            self._write(identifier, changed, names)

    # ── keeping ──────────────────────────────────────────────────────────────────────────

    def _require_writable(self) -> None:
        self._store.require_writable()

    def _checked(self, sequence: str) -> str:
        return self._recording(sequence).manifest.id

    def _opened(self, names: Sequence[str]) -> dict[str, Recording]:
        """Open recordings; examples of deleted ones and of other workspaces are kept."""
        found: dict[str, Recording] = {}
        for name in names:
            with suppress(NotFoundError):
                found[name] = self._recording(name)
        return found

    def _guard(self, identifier: str) -> threading.RLock:
        with self._lock:
            return self._locks.setdefault(identifier, threading.RLock())

    def _read(self, identifier: str) -> tuple[ClassNames, Classifier]:
        """Return the class names, and a classifier from the cache or its file."""
        names, known = self._store.class_names(), self._known.get(identifier)
        if (
            known is None
            or known[0].revision != names.revision
            or identifier not in self._files.ids()
        ):
            kept = self._files.read(identifier)
            known = names, kept.called([names.name(key) for key in kept.classes])
            self._known[identifier] = known
        return known

    def _write(self, identifier: str, classifier: Classifier, names: ClassNames) -> None:
        """Write a classifier with the keys of its classes."""
        keys = [names.key(name) for name in classifier.classes]
        self._files.write(identifier, classifier.called(keys))

    def _fresh(self, identifier: str, also: Sequence[str]) -> tuple[ClassNames, Classifier]:
        """Update a classifier and return it with the class names; requires its guard."""
        classes, known = self._read(identifier)
        names = tuple(dict.fromkeys([*known.taught_by, *also]))
        recordings, earlier = self._opened(names), self._opened(known.start_from)
        fresh = self._teacher.fresh(known, recordings, earlier)
        if fresh.recordings != names:
            fresh = replace(fresh, recordings=names)
            self._known[identifier] = classes, fresh
        if fresh is not known or (not fresh.ready and (fresh.examples or fresh.model)):
            fresh = fresh.learnt(self.options.forest, self._predictor.model(fresh))
            self._known[identifier] = classes, fresh
        return classes, fresh


def _local(recording: Recording, place: Sequence[float]) -> tuple[float, float, float]:
    """Return a place (3,), source metres, in the recording's local coordinates."""
    x, y, z = (np.asarray(place) - np.asarray(recording.manifest.shift)).tolist()
    return x, y, z


def _about(identifier: str, classifier: Classifier) -> values.Classifier:
    counts = dict(zip(classifier.classes, classifier.counts.tolist(), strict=True))
    return values.Classifier(
        identifier, classifier.name, classifier.classes, classifier.taught_by, counts,
        classifier.score, classifier.size, classifier.model,
        classifier.imported, dict(zip(classifier.classes, _held_out(classifier), strict=True)),
        classifier.above, classifier.start_from,
    )  # fmt: skip


def _held_out(classifier: Classifier) -> tuple[HeldOut, ...]:
    return classifier.held_out or (HeldOut(None, 0),) * len(classifier.classes)
