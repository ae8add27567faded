"""A selector on another machine, asked over HTTP: a promptable network with a GPU, say.

Version 1 of the calls, each a POST with an .npz body and an .npz answer:

``{address}/v1/prepare``     arrays ``xyz`` float32 (N, 3), and where the frame has them ``rgb``
                             uint8, ``intensity`` float32, ``viewpoint`` float64 (3,),
                             ``T_room_local`` float64 (4, 4); ``sensor`` text.
                             Answer: ``state`` uint8 (any length), opaque to pointbrush.
``{address}/v1/candidates``  ``state`` as answered, ``positives``, ``negatives`` float64 (·, 3),
                             ``mask`` int64 (n,).  Answer: ``scores`` float32 (C,), and
                             ``indices_0`` … ``indices_{C-1}`` int64, ascending; C at most 6.
                             Status 410: the state is not known any more.
"""

from __future__ import annotations

import io
import urllib.error
import urllib.request
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, UnavailableError
from pointbrush.selection.objects import ObjectFrame
from pointbrush.selection.selectors.interface import Mask, Region, StateLostError

Arrays = Mapping[str, NDArray[Any]]
MEDIA_TYPE = "application/x-npz"


@dataclass(frozen=True, slots=True)
class HttpOptions:
    """Bounds of a call."""

    prepare_seconds: float = 120.0
    """Longest wait for the answer to a frame."""
    click_seconds: float = 10.0
    """Longest wait for the answer to a click."""
    answer_bytes: int = 256 * 2**20
    """Greatest answer."""
    most_candidates: int = 6
    """Regions in an answer."""


@dataclass(frozen=True, slots=True, eq=False)
class _Remote:
    """The other side's word for a frame, and the frame's number of points."""

    state: NDArray[np.uint8]
    count: int


class HttpSelector:
    """Asks the service at ``address``; raises UnavailableError when it does not answer."""

    def __init__(self, address: str, options: HttpOptions | None = None) -> None:
        self._address, self._options = address.rstrip("/"), options or HttpOptions()
        if urlsplit(self._address).hostname is None:
            raise BadInputError(f"selector: expected http://host[:port][/path], got {address!r}")
        self.version = "http-1"

    def prepare(self, frame: ObjectFrame) -> _Remote:
        """Send a frame, and keep what it is called there."""
        arrays: dict[str, NDArray[Any]] = {
            "xyz": np.asarray(frame.xyz, np.float32),
            "sensor": np.array(frame.sensor),
        }
        for name in ("rgb", "intensity", "viewpoint", "T_room_local"):
            column = getattr(frame, name)
            if column is not None:
                arrays[name] = column
        answer = self._ask("prepare", arrays, self._options.prepare_seconds)
        return _Remote(_array(answer, "state", np.uint8), len(frame.xyz))

    def candidates(
        self,
        state: _Remote,
        positives: NDArray[np.float64],
        negatives: NDArray[np.float64],
        mask: Mask | None,
    ) -> Sequence[Region]:
        """Ask what clicks mean; see ``Selector``."""
        arrays: dict[str, NDArray[Any]] = {
            "state": state.state,
            "positives": positives,
            "negatives": negatives,
            "mask": np.empty(0, np.int64) if mask is None else mask,
        }
        answer = self._ask("candidates", arrays, self._options.click_seconds)
        scores = _array(answer, "scores", np.float32)
        if len(scores) > self._options.most_candidates:
            raise UnavailableError(
                f"selector: expected at most {self._options.most_candidates} candidates, "
                f"got {len(scores)}"
            )
        return [
            (_numbers(answer, f"indices_{i}", state.count), float(score))
            for i, score in enumerate(scores)
        ]

    def save(self, state: _Remote, path: Path) -> None:
        """Write a state to a file."""
        with path.open("wb") as file:
            np.savez(file, state=state.state, count=np.array(state.count))

    def load(self, path: Path) -> _Remote:
        """Read a state; raises BadInputError for anything else."""
        try:
            with np.load(path, allow_pickle=False) as stored:
                return _Remote(stored["state"], int(stored["count"]))
        except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise BadInputError(f"{path.name}: expected a saved state: {error}") from None

    def _ask(self, call: str, arrays: Arrays, seconds: float) -> Arrays:
        body = io.BytesIO()
        np.savez(body, **arrays)  # type: ignore[arg-type]  # numpy's stub takes no mapping
        request = urllib.request.Request(  # noqa: S310 – the operator's own address
            f"{self._address}/v1/{call}",
            data=body.getvalue(),
            headers={"Content-Type": MEDIA_TYPE},
            method="POST",
        )
        try:
            with urllib.request.urlopen(request, timeout=seconds) as response:  # noqa: S310
                data = response.read(self._options.answer_bytes + 1)
        except urllib.error.HTTPError as error:
            if error.code == HTTPStatus.GONE:
                raise StateLostError("selector: the frame must be prepared anew") from None
            raise UnavailableError(f"selector: expected an answer to {call}: {error}") from None
        except OSError as error:
            raise UnavailableError(f"selector: expected an answer to {call}: {error}") from None
        if len(data) > self._options.answer_bytes:
            raise UnavailableError(
                f"selector: expected an answer of at most {self._options.answer_bytes} bytes"
            )
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as answer:
                return dict(answer.items())
        except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise UnavailableError(f"selector: expected an .npz answer: {error}") from None


def _array(answer: Arrays, name: str, dtype: type) -> NDArray[Any]:
    found = answer.get(name)
    if found is None or found.ndim != 1 or found.dtype != dtype:
        got = "none" if found is None else f"{found.dtype} {found.shape}"
        raise UnavailableError(f"selector: expected {name} {np.dtype(dtype)} (n,), got {got}")
    return found


def _numbers(answer: Arrays, name: str, count: int) -> Mask:
    found = _array(answer, name, np.int64)
    if len(found) and not (found[0] >= 0 and found[-1] < count and (np.diff(found) > 0).all()):
        raise UnavailableError(f"selector: expected {name} ascending within 0..{count - 1}")
    return found
