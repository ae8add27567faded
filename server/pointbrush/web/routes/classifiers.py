"""Labels by example: classifiers, their predictions and their doubts."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from fastapi import Path, Query, Request, Response
from fastapi.concurrency import run_in_threadpool
from pydantic import FiniteFloat

from pointbrush.classify.options import MOST_BYTES, NAME_LENGTH
from pointbrush.ranges import ranges, runs_of
from pointbrush.streaming.messages import FrameIndex
from pointbrush.values.classifiers import (
    Application,
    Classifier,
    ClassName,
    DoubtAnswer,
    MoreExamples,
    NewClassifier,
    Place,
    PredictionRequest,
    Start,
)
from pointbrush.values.edits import Edit
from pointbrush.values.jobs import Job
from pointbrush.web.context import (
    SEQUENCE_ID,
    FramePath,
    RunOrder,
    SequenceId,
    Ws,
    body_within,
    id_query,
)
from pointbrush.web.problems import BINARY
from pointbrush.web.security.auth import Caller, TheGate, resource
from pointbrush.web.security.roles import needs, needs_for_file

if TYPE_CHECKING:
    from pointbrush.work.classifiers.predicting import Prediction

router = resource("classifiers")
MEDIA_TYPE = "application/octet-stream"
CLASSIFIER_ID = "classifier id"
ClassifierPath = Annotated[str, Path(pattern=SEQUENCE_ID, max_length=64, description=CLASSIFIER_ID)]
ClassifierQuery = Annotated[str, id_query(CLASSIFIER_ID)]


@router.get("/classifiers", **needs("viewer"))
def list_classifiers(workspace: Ws) -> list[Classifier]:
    """List the classifiers of the workspace, by id."""
    return workspace.classifiers.listing()


@router.post("/classifiers", status_code=201, **needs("annotator", 404))
def create_classifier(body: NewClassifier, workspace: Ws, who: Caller, gate: TheGate) -> Classifier:
    """Create a classifier that learns from the painted points of ``recordings``, now and later."""
    gate.require_seen(who, *body.recordings, *body.start_from)
    return workspace.classifiers.create(
        body.name, body.recordings, body.classes, body.model, body.imported, body.start_from
    )


@router.post(
    "/classifiers/file",
    status_code=201,
    **needs("manager", 413),
    openapi_extra={"requestBody": {"required": True, "content": {MEDIA_TYPE: BINARY}}},
)
async def bring_classifier(
    request: Request,
    workspace: Ws,
    name: Annotated[
        str | None, Query(min_length=1, max_length=NAME_LENGTH, description="its new name")
    ] = None,
) -> Classifier:
    """Import the file of a classifier, for example from another workspace."""
    data = bytes(await body_within(request, MOST_BYTES, "classifier"))
    return await run_in_threadpool(workspace.classifiers.import_file, data, name)


@router.get("/classifiers/{id}", **needs("viewer", 404))
def get_classifier(id: ClassifierPath, workspace: Ws) -> Classifier:
    """Return a classifier."""
    return workspace.classifiers.about(id)


@router.delete("/classifiers/{id}", status_code=204, **needs("manager", 404))
def delete_classifier(id: ClassifierPath, workspace: Ws) -> None:
    """Delete a classifier; the labels that it has predicted stay."""
    workspace.classifiers.delete(id)


@router.get("/classifiers/{id}/file", **needs_for_file("viewer", "The file", MEDIA_TYPE))
def get_classifier_file(id: ClassifierPath, workspace: Ws) -> Response:
    """Return a classifier as a file for another workspace."""
    headers = {"Content-Disposition": f'attachment; filename="{id}.npz"'}
    data = workspace.classifiers.file(id)
    return Response(data, media_type=MEDIA_TYPE, headers=headers)


@router.post("/classifiers/{id}/teach", **needs("annotator", 404))
def teach_classifier(
    id: ClassifierPath, body: MoreExamples, workspace: Ws, who: Caller, gate: TheGate
) -> Classifier:
    """Train on all painted points, also of further recordings, and store the classifier."""
    gate.require_seen(who, *body.recordings)
    return workspace.classifiers.teach(id, body.recordings)


@router.post(
    "/sequences/{seq}/frames/{i}/prediction",
    **needs_for_file(
        "annotator", "Classes and confidences", "application/zip", MEDIA_TYPE, problems=(404, 413)
    ),
)
def predict(
    seq: SequenceId,
    i: FramePath,
    body: PredictionRequest,
    workspace: Ws,
    format: Annotated[
        Literal["npz", "stored"],
        Query(description="`npz`: arrays in source order; `stored`: bytes for pages"),
    ] = "npz",
) -> Response:
    """Predict the classes of a frame's points from all painted points, without changing labels.

    ``npz``, source order: ``label`` uint16, 0 if the palette has no label of the class; ``class``
    uint8 from 1, 0 before the first training; ``confidence`` uint8; ``classes``, the names.  For a
    part of the frame also ``index`` uint32, the numbers of the points.  ``stored``: for pages, see
    docs/classifier.md.
    """
    prediction = workspace.classifiers.predict(
        body.classifier, seq, i, labels=body.labels, place=body.place
    )
    if format == "stored":
        return Response(stored_bytes(prediction), media_type=MEDIA_TYPE)
    arrays = _in_source_order(prediction, workspace.recording(seq)[i].source_index)
    file = io.BytesIO()
    np.savez(file, classes=np.array(prediction.classes), **arrays)
    return Response(file.getvalue(), media_type="application/zip")


def _in_source_order(prediction: Prediction, source: np.ndarray[Any, Any]) -> dict[str, Any]:
    """Arrays of a prediction, which is in stored order."""
    numbers = source if prediction.numbers is None else source[prediction.numbers]
    order = np.argsort(numbers)
    arrays = {
        "label": prediction.label[order],
        "class": prediction.kind[order],
        "confidence": prediction.confidence[order],
    }
    if prediction.numbers is not None:
        arrays["index"] = numbers[order].astype(np.uint32)
    return arrays


def stored_bytes(prediction: Prediction) -> bytes:
    """Return a prediction in stored order: a length uint32, JSON, then the arrays one by one."""
    about = {
        "points": len(prediction.kind),
        "part": prediction.numbers is not None,
        "classes": prediction.classes,
        "labels": prediction.labels,
        "confused": [
            [int(one), int(other), int(prediction.confused[one, other])]
            for one, other in np.argwhere(prediction.confused)
        ],
        "doubts": prediction.doubts.tolist(),
    }
    head = json.dumps(about).encode()
    head += b" " * (-(4 + len(head)) % 4)  # aligns the numbers of points, which are read in place
    parts = [len(head).to_bytes(4, "little"), head]
    if prediction.numbers is not None:
        parts.append(prediction.numbers.astype("<u4").tobytes())
    return b"".join([*parts, prediction.kind.tobytes(), prediction.confidence.tobytes()])


@router.get("/sequences/{seq}/starts", **needs("annotator", 404))
def list_starts(seq: SequenceId, workspace: Ws, who: Caller, gate: TheGate) -> list[Start]:
    """List the labelled recordings from which a classifier of this recording can start."""
    starts = workspace.classifiers.starts(seq)
    return [each for each in starts if gate.may_see(who, each.recording)]


@router.get("/sequences/{seq}/doubt", **needs("annotator", 404))
def get_doubt(
    seq: SequenceId,
    workspace: Ws,
    who: Caller,
    gate: TheGate,
    classifier: ClassifierQuery,
    frame: Annotated[FrameIndex | None, Query(description="only this frame")] = None,
    all: Annotated[bool, Query(alias="workspace", description="in other recordings, too")] = False,
    near: Annotated[
        list[FiniteFloat] | None,
        Query(
            min_length=3, max_length=3, description="x, y, z: round this position in a large frame"
        ),
    ] = None,
    most: Annotated[int, Query(ge=1, le=100, description="most places")] = 5,
    between: Annotated[
        list[ClassName] | None, Query(max_length=2, description="only between these classes")
    ] = None,
    format: RunOrder = "source",
) -> list[Place]:
    """List the places where a label would teach most, the best first, in one or in all frames."""
    places = workspace.classifiers.doubt(
        classifier, seq, frame=frame, workspace=all, near=near, most=most, between=between or ()
    )
    visible = [each for each in places if gate.may_see(who, each.sequence)]
    if format == "source":
        visible = [_in_source_runs(workspace, each) for each in visible]
    return visible


def _in_source_runs(workspace: Ws, place: Place) -> Place:
    stored = np.array(place.runs, np.int64)
    numbers = ranges(stored[:, 0], stored.sum(axis=1))
    source = workspace.recording(place.sequence)[place.frame].source_index[numbers]
    return replace(place, runs=tuple(map(tuple, runs_of(np.sort(source)).tolist())))


@router.post(
    "/sequences/{seq}/doubt/answers",
    **needs(
        "annotator", 404, 409, answers={204: {"description": "None of the classes, or skipped"}}
    ),
)
def answer_doubt(seq: SequenceId, body: DoubtAnswer, workspace: Ws, who: Caller) -> Edit:
    """Answer a doubt.

    A label is painted on the unlabelled and predicted points of the place, as one edit.  With none
    of the classes, the classifier leaves the place out of its predictions.  It does not ask about
    an answered or skipped place again.
    """
    place, classifiers = body.place, workspace.classifiers
    if body.class_ is not None:
        return classifiers.answer(
            body.classifier, seq, place.frame, place.centre, body.class_, author=who.author
        )
    classifiers.ignore(
        body.classifier, seq, place.frame, place.centre, place.radius, skipped=body.skip
    )
    return Response(status_code=204)  # type: ignore[return-value]


@router.delete("/sequences/{seq}/doubt/answers", status_code=204, **needs("annotator", 404))
def take_back_answer(
    seq: SequenceId,
    workspace: Ws,
    classifier: ClassifierQuery,
    centre: Annotated[
        list[FiniteFloat] | None,
        Query(min_length=3, max_length=3, description="x, y, z of the answer's place"),
    ] = None,
) -> None:
    """Take back an answer in this recording that was none of the classes, or skipped.

    By default the last one; with ``centre``, the one at this place.
    """
    workspace.classifiers.undo_ignore(classifier, seq, centre)


@router.post("/sequences/{seq}/predictions", status_code=202, **needs("annotator", 404, 409))
def apply_classifier(
    seq: SequenceId, body: Application, response: Response, workspace: Ws, who: Caller
) -> Job:
    """Label the unlabelled points of frames in a job; one edit of provenance 4."""
    job = workspace.predictions.start(seq, body, who.author)
    response.headers["Location"] = f"/api/v1/jobs/{job.id}"
    return job


@router.delete("/sequences/{seq}/features", status_code=204, **needs("annotator", 404))
def drop_features(seq: SequenceId, workspace: Ws) -> None:
    """Drop the cached features of a recording from memory."""
    workspace.classifiers.forget_features(seq)
