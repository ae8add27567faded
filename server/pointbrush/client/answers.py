"""Answers of the server: values, arrays and errors."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Hashable, Iterable, Mapping, Sequence
from functools import cache
from html import escape
from typing import Any, TypeAlias, TypeVar, cast

import httpx
import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import TypeAdapter

from pointbrush import errors
from pointbrush.values.boxes import FittedBoxes
from pointbrush.values.edits import Edit
from pointbrush.values.imports import ImportedLabels, ImportedRecording
from pointbrush.values.jobs import Job
from pointbrush.values.people import LabelledPeople
from pointbrush.values.tracking import Run

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
T = TypeVar("T")


@cache
def _adapter(kind: Hashable) -> TypeAdapter[Any]:
    return TypeAdapter(cast(Any, kind))


def read(kind: type[Value], entry: Any) -> Value:
    """Return an answer's JSON as a value of ``kind``; unknown members are ignored.

    Raises ValidationError for an answer of another shape, such as from another version.
    """
    found: Value = _adapter(cast(Hashable, kind)).validate_python(entry)
    return found


JobResult: TypeAlias = (
    Edit | FittedBoxes | ImportedLabels | ImportedRecording | LabelledPeople | Run
)
"""Results of jobs, by kind; predictions of classifiers are an ``Edit``."""


def result_of(job: Job, result: Mapping[str, Any]) -> JobResult:
    """Return the result of a job as a value."""
    kinds: dict[str, Any] = {
        "import": ImportedRecording if "sequence" in result else ImportedLabels,
        "prediction": LabelledPeople if "people" in result else Edit,
        "fitting": FittedBoxes,
        "tracking": Run,
    }
    found: JobResult = read(kinds[job.kind], result)
    return found


def tuple_of(items: Iterable[T] | None) -> tuple[T, ...] | None:
    """Return a tuple of items; None for None."""
    return None if items is None else tuple(items)


def vector(place: Sequence[float] | None) -> tuple[float, float, float] | None:
    """Return three numbers of any sequence, such as an array."""
    if place is None:
        return None
    x, y, z = (float(each) for each in place)
    return x, y, z


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


def mask_of(values: ArrayLike) -> NDArray[Any]:
    """Return a mask as uint8 or uint16; raises BadInputError for values that do not fit."""
    array = np.asarray(values)
    if array.dtype in (np.bool_, np.uint8):
        return array.astype(np.uint8)
    return layer_of(array, "label")


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
