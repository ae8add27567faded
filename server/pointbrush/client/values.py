"""Answers of the server as Python values."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from functools import cache
from html import escape
from typing import Annotated, Any, Literal, TypeVar, cast

import httpx
import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, PlainValidator, TypeAdapter

from pointbrush import errors

BY_TITLE = {
    kind.title: kind
    for kind in vars(errors).values()
    if isinstance(kind, type) and issubclass(kind, errors.PointbrushError)
}
BY_STATUS: dict[int, type[errors.PointbrushError]] = {
    400: errors.BadInputError,
    401: errors.UnauthorizedError,
    403: errors.ForbiddenError,
    404: errors.NotFoundError,
    409: errors.ConflictError,
    413: errors.TooLargeError,
    422: errors.BadInputError,
    429: errors.TooManyRequestsError,
    503: errors.UnavailableError,
}
AHEAD = (0.0, 0.0, -1.0)
"""Direction of a sample without one."""
LAYER_TYPES = {"label": np.uint16, "provenance": np.uint8, "deleted": np.bool_}
"""Types of a frame's layers on the server."""

Vector = tuple[float, float, float]
Floats = NDArray[np.float64]


def _square(values: Any) -> Floats:
    return np.asarray(values, np.float64).reshape(4, 4)


def _array(values: Any) -> Floats | None:
    return None if values is None else np.asarray(values, np.float64)


def _numbers(runs: Any) -> NDArray[np.int64]:
    parts = [np.arange(first, first + count) for first, count in runs]
    return np.concatenate(parts) if parts else np.empty(0, np.int64)


Pose = Annotated[Floats, PlainValidator(_square)]
Matrix = Annotated[Floats | None, PlainValidator(_array)]


@dataclass(frozen=True, slots=True)
class Bounds:
    """Corners over all frames, source coordinates, metres."""

    lo: Vector
    hi: Vector


@dataclass(frozen=True, slots=True)
class Manifest:
    """Facts of a recording; ``points`` per frame.

    ``changed``: time of the last edit, or else of the import.
    ``labelled``: number of frames with labels; ``labels``: number of labels; ``labels_used``:
    number of labels with points; ``labels_missing``: why the labels in its files were not imported.
    """

    id: str
    name: str
    frames: int
    fps: float
    points: tuple[int, ...]
    bounds: Bounds
    fields: tuple[str, ...]
    revision: int
    shift: Vector
    source: str
    large: bool
    created: datetime | None = None
    changed: datetime | None = None
    labelled: int = 0
    project: str = "default"
    labels: int = 0
    labels_used: int = 0
    labels_missing: str | None = None
    damaged: str | None = None
    identity: str | None = None
    deleted: datetime | None = None
    until: datetime | None = None


@dataclass(frozen=True, slots=True)
class Label:
    """A label of the palette; ``points`` in all frames, None where the answer has no count.

    ``Recording.labels`` counts the points.
    """

    id: int
    name: str
    category: str
    color: str
    locked: bool
    visible: bool
    points: int | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Edit:
    """A durable edit: its id, number of changed points, and revision of the recording."""

    edit: str
    changed: int
    revision: int


@dataclass(frozen=True, slots=True)
class PastEdit:
    """An edit of the history."""

    id: str
    revision: int
    author: str
    time: datetime
    kind: str
    summary: str
    points: int
    frames: tuple[int, ...]
    undone: bool


@dataclass(frozen=True, slots=True)
class Track:
    """A label's track in a frame; ``pose`` (4, 4) maps the start frame to this frame."""

    label: int
    frame: int
    pose: Pose
    rmse: float | None
    inliers: float
    confidence: float
    points: int
    state: Literal["tracked", "occluded", "lost", "painted"]


@dataclass(frozen=True, slots=True)
class Run:
    """Result of a tracking run, which is one edit."""

    edit: str
    changed: int
    revision: int
    frames: int


@dataclass(frozen=True, slots=True)
class Camera:
    """A camera with a picture: it projects a source point p to ``K (T_camera_frame p)``."""

    name: str
    width: int
    height: int
    K: Matrix
    distortion: tuple[float, ...]
    model: str
    T_camera_frame: Matrix


@dataclass(frozen=True, slots=True)
class Candidate:
    """A candidate for clicks on an object; ``numbers`` of its points, source order."""

    id: str
    level: int
    score: float
    points: int
    numbers: Annotated[NDArray[np.int64], Field(alias="runs"), PlainValidator(_numbers)]


@dataclass(frozen=True, slots=True)
class Job:
    """Long work on the server; ``progress`` 0..1."""

    id: str
    kind: str
    sequence: str | None
    state: Literal["queued", "running", "done", "failed", "cancelled"]
    progress: float
    message: str
    result: dict[str, Any] | None
    error: str | None


@dataclass(frozen=True, slots=True)
class Category:
    """A class of the workspace; ``datasets``: its number in datasets, by name.

    ``size``: mean length, width and height of its objects, metres; ``spread``: their standard
    deviation.
    """

    number: int
    name: str
    color: str = ""
    datasets: dict[str, int] = field(default_factory=dict)
    size: Vector | None = None
    spread: Vector | None = None


@dataclass(frozen=True, slots=True)
class BoxAttribute:
    """An attribute of boxes, with one value per track or per frame."""

    name: str
    kind: Literal["text", "choice", "number", "yes/no"]
    scope: Literal["track", "frame"] = "track"
    choices: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ExportFormat:
    """An export format; ``cannot_hold``: content that is lost in it.

    ``splits``: it divides frames into training and validation.  ``classes``: a label without a
    category becomes a class of its own in it.
    """

    format: str
    title: str
    content: str
    cannot_hold: list[str]
    splits: bool = False
    classes: bool = False


class Annotation(np.ndarray[Any, np.dtype[Any]]):
    """A layer of a frame (N,); pass its ``etag`` to ``Frame.annotate`` as ``if_match``."""

    etag: str

    def __new__(cls, values: NDArray[Any], etag: str) -> Annotation:
        """Wrap an array."""
        made = np.asarray(values).view(cls)
        made.etag = etag
        return made

    def __array_finalize__(self, other: Any) -> None:
        """Copy ``etag`` from the viewed array."""
        self.etag = getattr(other, "etag", "")


Value = TypeVar("Value")


@cache
def _adapter(kind: Hashable) -> TypeAdapter[Any]:
    return TypeAdapter(cast(Any, kind))


def read(kind: type[Value], entry: Any) -> Value:
    """Return an answer's JSON as a value of ``kind``; unknown members are ignored.

    Raises ValidationError for an answer of another shape, such as from another version.
    """
    found: Value = _adapter(cast(Hashable, kind)).validate_python(entry)
    return found


def raise_for(answer: httpx.Response) -> None:
    """Raise the error in the server's problem details, unless the answer is a success."""
    if answer.is_success:
        return
    try:
        problem = answer.json()
    except ValueError:
        problem = {}
    detail = str(problem.get("detail") or answer.reason_phrase or answer.status_code)
    kind = BY_TITLE.get(str(problem.get("title"))) or BY_STATUS.get(answer.status_code)
    raise (kind or errors.PointbrushError)(detail)


def array_of(answer: httpx.Response) -> NDArray[Any]:
    """Return the array of an ``.npy`` answer."""
    array: NDArray[Any] = np.load(io.BytesIO(answer.content), allow_pickle=False)
    return array


def layer_of(values: ArrayLike, layer: str) -> NDArray[Any]:
    """Return values in the type of a layer; raises BadInputError for values that do not fit.

    Values of an unknown layer are returned unchanged; the server refuses them.
    """
    array, dtype = np.asarray(values), LAYER_TYPES.get(layer)
    if dtype is None or array.dtype == dtype or array.dtype.kind not in "biuf":
        return array
    with np.errstate(invalid="ignore"):
        made: NDArray[Any] = array.astype(dtype)
    wrong = array[made != array]
    if wrong.size:
        raise errors.BadInputError(
            f"values: expected whole numbers that fit {np.dtype(dtype)}, got {wrong[0]}"
        )
    return made


def npy_of(values: NDArray[Any]) -> bytes:
    """Return an array as ``.npy``."""
    content = io.BytesIO()
    np.save(content, np.asarray(values), allow_pickle=False)
    return content.getvalue()


def npz_of(arrays: Mapping[int, NDArray[Any]]) -> bytes:
    """Return arrays by frame as a compressed ``.npz``."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for frame, array in arrays.items():
            archive.writestr(f"{frame}.npy", npy_of(array))
    return content.getvalue()


def rays(origins: ArrayLike, directions: ArrayLike | None = None) -> list[dict[str, Any]]:
    """Return samples of a stroke from arrays (S, 3); without directions the samples are places."""
    places = np.asarray(origins, np.float64).reshape(-1, 3)
    ways = np.asarray(AHEAD if directions is None else directions, np.float64)
    pairs = zip(places.tolist(), np.broadcast_to(ways, places.shape).tolist(), strict=True)
    return [{"origin": origin, "direction": way} for origin, way in pairs]


def html_table(caption: str, facts: Mapping[str, str]) -> str:
    """Return an HTML table of facts, with a row for each."""
    rows = "".join(f"<tr><th>{n}</th><td>{escape(value)}</td></tr>" for n, value in facts.items())
    return f"<table><caption>{escape(caption)}</caption>{rows}</table>"
