"""Calls of a model's service over HTTP: an .npz body, an .npz answer; nothing is trusted."""

from __future__ import annotations

import io
import urllib.error
import urllib.request
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, UnavailableError

Arrays = Mapping[str, NDArray[Any]]
MEDIA_TYPE = "application/x-npz"


@dataclass(frozen=True, slots=True)
class NpzService:
    """A service at ``address``; ``role`` is what error messages call it.

    ``most_bytes``: of an answer.  Raises BadInputError for what is no address.
    """

    address: str
    role: str
    most_bytes: int
    gone: type[UnavailableError] = UnavailableError
    """Raised where the service answers that it does not know a state any more (410)."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "address", self.address.rstrip("/"))
        if urlsplit(self.address).hostname is None:
            got = repr(self.address)
            raise BadInputError(f"{self.role}: expected http://host[:port][/path], got {got}")

    def ask(self, call: str, arrays: Arrays, seconds: float) -> Arrays:
        """Send arrays to ``{address}/v1/{call}``; raises UnavailableError for no good answer."""
        body = io.BytesIO()
        np.savez(body, **arrays)  # type: ignore[arg-type]  # numpy's stub takes no mapping
        request = urllib.request.Request(  # noqa: S310 – the operator's own address
            f"{self.address}/v1/{call}",
            data=body.getvalue(),
            headers={"Content-Type": MEDIA_TYPE},
            method="POST",
        )
        try:
            with urllib.request.urlopen(request, timeout=seconds) as response:  # noqa: S310
                data = response.read(self.most_bytes + 1)
        except urllib.error.HTTPError as error:
            if error.code == HTTPStatus.GONE:
                raise self.gone(f"{self.role}: the frame must be prepared anew") from None
            raise self._unanswered(call, error) from None
        except OSError as error:
            raise self._unanswered(call, error) from None
        if len(data) > self.most_bytes:
            raise UnavailableError(
                f"{self.role}: expected an answer of at most {self.most_bytes} bytes"
            )
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as answer:
                return dict(answer.items())
        except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise UnavailableError(f"{self.role}: expected an .npz answer: {error}") from None

    def array(self, answer: Arrays, name: str, dtype: type) -> NDArray[Any]:
        """Return a flat array of an answer; raises UnavailableError for another."""
        found = answer.get(name)
        if found is None or found.ndim != 1 or found.dtype != dtype:
            got = "none" if found is None else f"{found.dtype} {found.shape}"
            raise UnavailableError(
                f"{self.role}: expected {name} {np.dtype(dtype)} (n,), got {got}"
            )
        return found

    def _unanswered(self, call: str, error: Exception) -> UnavailableError:
        return UnavailableError(f"{self.role}: expected an answer to {call}: {error}")
