"""Answers of the server as Python values."""

from __future__ import annotations

import io
from typing import Any

import httpx
import numpy as np
from numpy.typing import NDArray

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


class Annotation(np.ndarray[Any, np.dtype[Any]]):
    """A layer of a frame (N,); ``etag`` is what ``Frame.annotate`` is given as ``if_match``."""

    etag: str

    def __new__(cls, values: NDArray[Any], etag: str) -> Annotation:
        """Wrap an array."""
        made = np.asarray(values).view(cls)
        made.etag = etag
        return made

    def __array_finalize__(self, other: Any) -> None:
        """Keep ``etag`` of what this is a view of."""
        self.etag = getattr(other, "etag", "")


def raise_for(answer: httpx.Response) -> None:
    """Raise the error that the server names in a problem; nothing for a success."""
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
    """The array of an ``.npy`` answer."""
    array: NDArray[Any] = np.load(io.BytesIO(answer.content), allow_pickle=False)
    return array


def npy_of(values: NDArray[Any]) -> bytes:
    """An array as ``.npy``."""
    content = io.BytesIO()
    np.save(content, np.asarray(values), allow_pickle=False)
    return content.getvalue()
