"""Jobs that apply a classifier to frames and commit the result as one edit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.classifier import Classifier, from_file, to_file
from pointbrush.classify.features import Described, ExampleFrame, describe
from pointbrush.classify.models import Model, Models
from pointbrush.classify.smoothing import Chances, point_classes
from pointbrush.database.job import Job
from pointbrush.errors import BadInputError
from pointbrush.jobs.job import MESSAGE
from pointbrush.jobs.runner import Receiver
from pointbrush.jobs.worker import Channel
from pointbrush.labels import Label, LabelStore, Write
from pointbrush.labels.classes.palette import Palette
from pointbrush.labels.plans import Writes
from pointbrush.labels.types import FULL_CONFIDENCE, PREDICTED
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import open_sequence
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.values.classifiers import Application
from pointbrush.work.annotate.layers import Packed
from pointbrush.work.classifiers import PREDICT
from pointbrush.work.classifiers.agreeing import average_chances, voter_of
from pointbrush.work.classifiers.frames import example_frame, pieces
from pointbrush.work.classifiers.ignoring import ignored_cells
from pointbrush.work.classifiers.naming import label_of
from pointbrush.work.classifiers.options import ClassifierOptions
from pointbrush.work.classifiers.service import Classifiers
from pointbrush.work.exporting import parse_frames
from pointbrush.work.job_request import JobRequest
from pointbrush.work.job_service import EditService, JobContext, Submission, edit_result


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """Classes, from 1, and confidences of points; ``numbers``: of a piece, None: all points."""

    frame: int
    numbers: NDArray[np.int64] | None
    kind: Packed
    confidence: Packed


@dataclass(frozen=True)
class PredictingWork:
    """Picklable work that sends each piece's ``Found`` as an item."""

    files: RecordingFiles
    classifier: bytes = field(repr=False)
    frames: tuple[int, ...]
    options: ClassifierOptions
    models: Models

    def __call__(self, channel: Channel) -> None:
        """Predict frame by frame, and large frames piece by piece."""
        recording, model = open_sequence(self.files), from_file(self.classifier)
        own = self.models.make(model.model) if model.model else None
        total = sum(recording[frame].count for frame in self.frames) or 1
        done, kept = 0, dict[int, tuple[Described, Chances]]()
        for frame in self.frames:
            for found, count in predict_frame(recording, frame, model, self.options, own, kept):
                channel.item(found)
                done += count
                channel.progress(min(done / total, 1.0), f"frame {frame}")


def predict_frame(
    recording: Recording, frame: int, model: Classifier, options: ClassifierOptions,
    own: Model | None = None, kept: dict[int, tuple[Described, Chances]] | None = None,
) -> Iterator[tuple[Found, int]]:  # fmt: skip
    """Yield the predicted classes of a frame and the number of points.

    ``own``: the model used instead of its trees; ``kept``: cache of the prediction for a frame that
    other frames are compared with.
    """
    kept = {} if kept is None else kept

    def classify(made: ExampleFrame) -> tuple[Described, Chances]:
        place = describe(made, model.size, options.features)
        return place, model.chances(place, lambda: made, own)

    def predict_other(voter: int) -> tuple[Described, Chances]:
        if voter not in kept:
            kept.clear()
            kept[voter] = classify(example_frame(recording, voter))
        return kept[voter]

    count = recording[frame].count
    if count == 0:
        return
    if count <= options.whole_points:
        place, chance = classify(example_frame(recording, frame))
        voter = voter_of(model, recording, frame, options.whole_points)
        if voter is not None:
            chance = average_chances(recording, frame, place, chance, voter, predict_other)
        kind, sure = point_classes(chance, place.of_point)
        kind[ignored_cells(model, recording, frame, place, None)[place.of_point]] = 0
        yield Found(frame, None, Packed.of(kind), Packed.of(sure)), count
        return
    for piece in pieces(recording, frame, options.piece_points, options.margin * model.size):
        place, chance = classify(example_frame(recording, frame, piece.members))
        kind, sure = point_classes(chance, place.of_point)
        kind[ignored_cells(model, recording, frame, place, piece.members)[place.of_point]] = 0
        inside = piece.inside
        yield (
            Found(frame, piece.members[inside], Packed.of(kind[inside]), Packed.of(sure[inside])),
            int(inside.sum()),
        )


@dataclass(frozen=True)
class ApplyRequest(JobRequest):
    """Request to apply a classifier to ``frames`` of a recording."""

    call = PREDICT
    frames: tuple[int, ...]
    options: Application


class Predictions(EditService[ApplyRequest]):
    """Starts jobs that apply classifiers, and commits their results."""

    kind = "prediction"
    request = ApplyRequest

    def __init__(self, context: JobContext, classifiers: Classifiers) -> None:
        super().__init__(context)
        self._classifiers = classifiers

    def start(self, sequence: str, body: Application, author: str) -> Job:
        """Label unlabeled points in a job, or return the job that ``author`` started by this id.

        Raises NotFoundError (frame, classifier), BadInputError (no examples, no frame).
        """
        recording = self._recording(sequence)
        self._classifiers.about(body.classifier)
        frames = tuple(parse_frames(body.frames or None, len(recording)))
        return self.begin(sequence, ApplyRequest(frames, body), author, body.id)

    def _prepare(self, request: ApplyRequest, job: Job) -> Submission:
        recording = self._recording(job.sequence or "")
        self._store.require_writable()
        if not request.frames:
            raise BadInputError("frames: expected at least one, got none")
        for frame in request.frames:
            _ = recording[frame]
        model = self._classifiers.current(request.options.classifier)
        if not model.ready:
            raise BadInputError(
                "classifier: expected a trained classifier, no points are painted yet"
            )
        known = self._classifiers
        work = PredictingWork(
            recording.files, to_file(model), request.frames, known.options, known.models
        )
        return job, work, _Prediction(self._store, recording, model, request)


class _Prediction(Receiver):
    """Commits the classes as one edit, except points that were painted, erased or tracked."""

    def __init__(
        self, store: LabelStore, recording: Recording, model: Classifier, request: ApplyRequest
    ) -> None:
        super().__init__()
        self.store, self.recording, self.model, self.request = store, recording, model, request

    def finish(self, job: Job, cancelled: bool) -> dict[str, Any]:
        if cancelled:
            return {"edit": None, "changed": 0, MESSAGE: "no label was changed"}
        name, frames = self.model.name, len(self.request.frames)
        many = "1 frame" if frames == 1 else f"{frames} frames"
        commit = self.store.apply(
            self.recording.manifest.id,
            edit_id=job.edit or job.id,
            author=job.owner or "",
            kind="prediction",
            writes=self._choose,
            summary=f"predicted {many} by '{name}'"[:200],
            identity=self.recording.identity,
        )
        message = f"{commit.changed:,} points labelled"
        return edit_result(commit) | {"frames": frames, MESSAGE: message}

    def _choose(self, palette: Palette) -> tuple[Sequence[Label], Writes]:
        """Return the labels and writes for the palette at the commit."""
        ids, added, new = palette.free_ids(), [], np.zeros(len(self.model.classes) + 1, np.uint16)
        taught = self.model.counts > 0
        for number, name in enumerate(self.model.classes, 1):
            name = palette.classes.meaning(name)  # the class may have been renamed
            label = label_of(name, palette.labels)
            if label is None and taught[number - 1]:
                label = Label(ids.take((name, name)), name, name)
                added.append(label)
            # Hidden and locked labels are not predicted.
            if label is not None and label.visible and not label.locked:
                new[number] = label.id
        return added, self._writes(new)

    def _writes(self, ids: NDArray[np.uint16]) -> Iterator[tuple[int, Write]]:
        above = self.request.options.above
        least = (self.model.above if above is None else above) * FULL_CONFIDENCE
        for each in self.items:
            label, sure = ids[each.kind.values()], each.confidence.values()
            kept = np.flatnonzero((label > 0) & (sure >= least))
            numbers = kept if each.numbers is None else each.numbers[kept]
            yield (
                each.frame,
                Write(
                    numbers, label=label[kept], provenance=PREDICTED, confidence=sure[kept],
                    only="predictable", living=True, hidden=frozenset(),
                ),
            )  # fmt: skip
