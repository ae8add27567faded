"""A remote selector over HTTP, such as a promptable network with a GPU.

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

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, UnavailableError
from pointbrush.exchange.npz import Arrays, checked, read_npz
from pointbrush.exchange.npz_service import NpzService
from pointbrush.selection.objects import ObjectFrame
from pointbrush.selection.selectors.interface import Mask, Region, StateLostError


@dataclass(frozen=True, slots=True)
class HttpOptions:
    """Limits of a call."""

    prepare_seconds: float = 120.0
    """Timeout of the answer to a frame."""
    click_seconds: float = 10.0
    """Timeout of the answer to a click."""
    answer_bytes: int = 256 * 2**20
    """Maximum size of an answer in bytes."""
    most_candidates: int = 6
    """Maximum number of regions in an answer."""


@dataclass(frozen=True, slots=True, eq=False)
class _Remote:
    """The service's state of a frame, and the frame's number of points."""

    state: NDArray[np.uint8]
    count: int


class HttpSelector:
    """Client of the service at ``address``; raises UnavailableError if it does not answer."""

    def __init__(self, address: str, options: HttpOptions | None = None) -> None:
        self._options = options or HttpOptions()
        most = self._options.answer_bytes
        self._service = NpzService(address, "selector", most, gone=StateLostError)
        self.version = "http-1"

    def prepare(self, frame: ObjectFrame) -> _Remote:
        """Send a frame; return the service's state of it."""
        arrays: dict[str, NDArray[Any]] = {
            "xyz": np.asarray(frame.xyz, np.float32),
            "sensor": np.array(frame.sensor),
        }
        for name in ("rgb", "intensity", "viewpoint", "T_room_local"):
            column = getattr(frame, name)
            if column is not None:
                arrays[name] = column
        answer = self._service.call("prepare", arrays, self._options.prepare_seconds)
        return _Remote(self._service.array(answer, "state", np.uint8), len(frame.xyz))

    def candidates(
        self,
        state: _Remote,
        positives: NDArray[np.float64],
        negatives: NDArray[np.float64],
        mask: Mask | None,
    ) -> Sequence[Region]:
        """Return the candidates of clicks; see ``Selector``."""
        arrays: dict[str, NDArray[Any]] = {
            "state": state.state,
            "positives": positives,
            "negatives": negatives,
            "mask": np.empty(0, np.int64) if mask is None else mask,
        }
        answer = self._service.call("candidates", arrays, self._options.click_seconds)
        scores = self._service.array(answer, "scores", np.float32)
        if len(scores) > self._options.most_candidates:
            raise UnavailableError(
                f"selector: expected at most {self._options.most_candidates} candidates, "
                f"got {len(scores)}"
            )
        return [
            (self._numbers(answer, f"indices_{i}", state.count), float(score))
            for i, score in enumerate(scores)
        ]

    def save(self, state: _Remote, path: Path) -> None:
        """Write a state to a file."""
        with path.open("wb") as file:
            np.savez(file, state=state.state, count=np.array(state.count))

    def load(self, path: Path) -> _Remote:
        """Read a state; raises BadInputError for anything else."""
        try:
            stored = read_npz(path, self._options.answer_bytes)
            count = int(checked(stored, "count", np.int64, ()))
            return _Remote(checked(stored, "state", np.uint8, (None,)), count)
        except (OSError, BadInputError) as error:
            raise BadInputError(f"{path.name}: expected a saved state: {error}") from None

    def _numbers(self, answer: Arrays, name: str, count: int) -> Mask:
        found = self._service.array(answer, name, np.int64)
        if len(found) and not (found[0] >= 0 and found[-1] < count and (np.diff(found) > 0).all()):
            raise UnavailableError(f"selector: expected {name} ascending within 0..{count - 1}")
        return found
