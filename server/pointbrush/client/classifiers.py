"""Label by example: classifiers of a workspace, trained on the painted points of recordings."""

from __future__ import annotations

import io
import uuid
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np
from numpy.typing import NDArray

from pointbrush.client.answers import read, tuple_of, vector
from pointbrush.client.steps import PATIENCE, L, Part, Request, Steps, finished, started, steps
from pointbrush.client.uploads import AnyPath
from pointbrush.values.classifiers import (
    Application,
    Classifier,
    DoubtAnswer,
    DoubtPlace,
    MoreExamples,
    NewClassifier,
    Place,
    PredictionRequest,
    Start,
)
from pointbrush.values.edits import Edit
from pointbrush.values.jobs import Job


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """A classifier's prediction of points of a frame, in source order.

    ``label`` (n,) uint16, 0 if the palette has no label of the class; ``kind`` (n,) uint8 number
    of the class in ``classes`` from 1, 0 without training; ``confidence`` (n,) uint8;
    ``index`` (n,) numbers of the points, None: all.
    """

    label: NDArray[np.uint16]
    kind: NDArray[np.uint8]
    confidence: NDArray[np.uint8]
    classes: tuple[str, ...]
    index: NDArray[np.uint32] | None


class Classifiers(Part[L]):
    """The classifiers of a workspace."""

    @steps
    def all(self) -> Steps[list[Classifier]]:
        """Return all classifiers, by id."""
        return self._get(list[Classifier], "/classifiers")

    @steps
    def __getitem__(self, classifier: str) -> Steps[Classifier]:
        """Return a classifier by its id; raises NotFoundError."""
        return self._get(Classifier, f"/classifiers/{classifier}")

    @steps
    def create(
        self, name: str, recordings: Sequence[str], classes: Sequence[str] | None = None,
        model: str = "", imported: bool = False, start_from: Sequence[str] = (),
    ) -> Steps[Classifier]:  # fmt: skip
        """Add a classifier that is trained on the painted points of recordings; return it.

        ``classes`` None: all of the recordings' palettes.  ``model``: name of a plug-in or service
        of the server to use instead of the trees.  ``imported``: train on imported labels as well.
        ``start_from``: labelled recordings; the more is painted here, the less they count.
        """
        body = NewClassifier(
            name, tuple(recordings), tuple_of(classes), model, imported, tuple(start_from)
        )
        return self._change(Classifier, "POST", "/classifiers", body, idempotent=False)

    @steps
    def teach(self, classifier: str, recordings: Sequence[str] = ()) -> Steps[Classifier]:
        """Train on the current labels, also of further recordings, and save the classifier."""
        body = MoreExamples(tuple(recordings))
        return self._change(Classifier, "POST", f"/classifiers/{classifier}/teach", body)

    @steps
    def delete(self, classifier: str) -> Steps[None]:
        """Delete a classifier; the labels that it applied stay."""
        yield from self._call("DELETE", f"/classifiers/{classifier}")

    @steps
    def save(self, classifier: str, out: AnyPath) -> Steps[Path]:
        """Write a classifier to a file for ``load``, and return the file's path."""
        target = Path(out)
        answer = yield from self._call("GET", f"/classifiers/{classifier}/file")
        target.write_bytes(answer.content)
        return target

    @steps
    def load(self, file: AnyPath, name: str | None = None) -> Steps[Classifier]:
        """Add a classifier from a file of ``save``, and return it; ``name``: its new name."""
        content = Path(file).read_bytes()
        place = "/classifiers/file"
        answer = yield from self._call("POST", place, content=content, params={"name": name})
        return read(Classifier, answer.json())


class ByExample(Part[L]):
    """Predictions of a recording by classifiers, and their application as labels."""

    @steps
    def predict(
        self,
        classifier: str,
        frame: int,
        *,
        labels: Sequence[int] | None = None,
        place: Sequence[float] | None = None,
    ) -> Steps[Prediction]:
        """Predict the points of a frame from all current labels; nothing is changed.

        ``labels``: predict only these, by id.  ``place`` (3,): predict only near it, source
        metres; a frame of many millions of points needs a place.
        """
        body = PredictionRequest(classifier, tuple_of(labels), vector(place)).to_json()
        path = f"/frames/{frame}/prediction"
        return _prediction((yield from self._call("POST", path, json=body, idempotent=True)))

    @steps
    def starts(self) -> Steps[dict[str, tuple[str, ...]]]:
        """Return the recordings that a classifier of this one can start from, with classes."""
        starts = yield from self._get(list[Start], "/starts")
        return {start.recording: start.classes for start in starts}

    @steps
    def doubt(
        self,
        classifier: str,
        *,
        frame: int | None = None,
        workspace: bool = False,
        near: Sequence[float] | None = None,
        most: int = 5,
    ) -> Steps[list[Place]]:
        """Return the places with the most useful answers for training, the best first.

        The search covers one ``frame``, or some frames, or some recordings of the ``workspace``.
        ``near`` (3,) source metres: search only near a place of a large frame.  ``most``: maximum
        number of places.
        """
        query = {"classifier": classifier, "most": most, "frame": frame, "near": vector(near)}
        return self._get(list[Place], "/doubt", **query, workspace="true" if workspace else None)

    @steps
    def answer(self, classifier: str, place: Place, label: int) -> Steps[int]:
        """Answer a doubt with a label: paint its points; return how many have changed."""
        answer = yield from self._answer(classifier, place, label=label)
        return int(answer.json()["changed"])

    @steps
    def ignore(self, classifier: str, place: Place, *, skip: bool = False) -> Steps[None]:
        """Answer a doubt with none of the classes: it is not asked or predicted again.

        ``skip``: it is predicted, but not asked again.
        """
        yield from self._answer(classifier, place, skip=skip)

    def _answer(
        self, classifier: str, place: Place, *, label: int | None = None, skip: bool = False
    ) -> Steps[httpx.Response]:
        about = DoubtPlace(place.frame, place.centre, place.radius)
        body = DoubtAnswer(classifier, about, label, skip).to_json()
        return self._call("POST", "/doubt/answers", json=body)

    @steps
    def take_back(self, classifier: str, place: Place | None = None) -> Steps[None]:
        """Take back the answer of ``ignore`` at a place, or the last one; raises NotFoundError."""
        query = {"classifier": classifier, "centre": place and place.centre}
        yield from self._call("DELETE", "/doubt/answers", params=query)

    @steps
    def start(
        self, /, classifier: str, frames: str = "", above: float | None = None, *,
        patience: float = PATIENCE,
    ) -> Steps[Job]:  # fmt: skip
        """Start an application and return its job; arguments as of ``apply``."""
        return self._start(classifier, frames, above, patience)

    @steps
    def apply(
        self, /, classifier: str, frames: str = "", above: float | None = None, *,
        progress: bool = False, patience: float = PATIENCE,
    ) -> Steps[Edit]:  # fmt: skip
        """Label unlabeled and predicted points in frames ``I:J``, and wait; return the result.

        The labels are one edit of provenance 4 (predicted).  ``above``: minimum confidence, 0 to 1;
        by default as measured in held-out places.
        ``patience``: as of ``Recording.track``.
        """
        job = yield from self._start(classifier, frames, above, patience)
        return read(Edit, (yield from finished(job, progress=progress, patience=patience)))

    def _start(
        self, classifier: str, frames: str, above: float | None, patience: float
    ) -> Steps[Job]:
        job = str(uuid.uuid4())
        body = Application(classifier, frames, above, job).to_json()
        place = f"{self._place}/predictions"
        return started(job, Request("POST", place, {"json": body}, patience=patience))


def _prediction(answer: httpx.Response) -> Prediction:
    with np.load(io.BytesIO(answer.content), allow_pickle=False) as found:
        return Prediction(
            found["label"],
            found["class"],
            found["confidence"],
            tuple(found["classes"].tolist()),
            found.get("index"),
        )
