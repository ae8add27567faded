"""Calls of a model's service over HTTP: an .npz body, an .npz answer; nothing is trusted."""

from __future__ import annotations

import io
import threading
from collections import defaultdict
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, PointbrushError, UnavailableError
from pointbrush.exchange.npz import Arrays, checked, read_npz
from pointbrush.exchange.outgoing import Bounds, exchange, parse_url

MEDIA_TYPE = "application/x-npz"
TIMEOUT = 120.0
"""Longest wait for the answer of a model, seconds."""
AT_ONCE = 4
"""Calls of one service at a time: one that hangs keeps no more threads of this process."""
_calls: defaultdict[str, threading.BoundedSemaphore] = defaultdict(
    lambda: threading.BoundedSemaphore(AT_ONCE)
)


@dataclass(frozen=True, slots=True)
class NpzService:
    """A service at ``address``; ``role`` is its name in error messages.

    ``most_bytes``: of an answer, packed and unpacked.  Raises BadInputError for an invalid address.
    """

    address: str
    role: str
    most_bytes: int
    gone: type[UnavailableError] = UnavailableError
    """Raised where the service answers that it does not know a state any more (410)."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "address", self.address.rstrip("/"))
        try:
            parse_url(self.address)
        except BadInputError as error:
            raise BadInputError(f"{self.role}: {error}") from None

    def call(self, call: str, arrays: Arrays, seconds: float) -> Arrays:
        """Send arrays to ``{address}/v1/{call}``; raises UnavailableError for no good answer."""
        body = io.BytesIO()
        np.savez(body, **arrays)  # type: ignore[arg-type]  # numpy's stub takes no mapping
        calls = _calls[self.address]
        if not calls.acquire(blocking=False):
            raise self._no_answer(call, f"{AT_ONCE} calls of it wait already")
        try:
            answer = exchange(
                "POST",
                f"{self.address}/v1/{call}",
                Bounds(seconds, self.most_bytes),
                headers={"Content-Type": MEDIA_TYPE},
                body=body.getvalue(),
            )
        except PointbrushError as error:
            raise self._no_answer(call, error) from None
        finally:
            calls.release()
        if answer.status == HTTPStatus.GONE:
            raise self.gone(f"{self.role}: the frame must be prepared anew")
        if not answer.success:
            raise self._no_answer(call, f"status {answer.status}")
        try:
            return read_npz(answer.body, self.most_bytes)
        except BadInputError as error:
            raise self._no_answer(call, error) from None

    def array(self, answer: Arrays, name: str, dtype: type) -> NDArray[Any]:
        """Return a flat array of an answer; raises UnavailableError for another."""
        try:
            return checked(answer, name, dtype, (None,))
        except BadInputError as error:
            raise UnavailableError(f"{self.role}: {error}") from None

    def _no_answer(self, call: str, reason: object) -> UnavailableError:
        return UnavailableError(f"{self.role}: expected an answer to {call}: {reason}")
