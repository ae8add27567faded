"""Interface of selectors."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import UnavailableError

if TYPE_CHECKING:
    from pointbrush.selection.objects import ObjectFrame

Mask = NDArray[np.int64]
"""Numbers of points, ascending."""
Region = tuple[Mask, float]
"""Numbers of the points of a candidate, and its score: the expected overlap, 0 to 1."""


class StateLostError(UnavailableError):
    """A selector has lost a state; its frame must be prepared again."""


class Selector(Protocol):
    """Prepares frames, and answers clicks on them; called from several threads."""

    def prepare(self, frame: ObjectFrame) -> Any:
        """Prepare a frame for answers; may take seconds."""

    def candidates(
        self,
        state: Any,
        positives: NDArray[np.float64],
        negatives: NDArray[np.float64],
        mask: Mask | None,
    ) -> Sequence[Region]:
        """Return at most six regions, the best first.

        ``positives`` (K, 3) and ``negatives`` (L, 3) are places on the surface, in local metres;
        ``mask``: points taken so far.
        """


@runtime_checkable
class StoredSelector(Protocol):
    """A selector with states that are computed in a separate process and stored on disk."""

    version: str
    """Version of its states; states of another version are prepared again."""

    def save(self, state: Any, path: Path) -> None:
        """Write a state to a file."""

    def load(self, path: Path) -> Any:
        """Read a file of ``save``; raises BadInputError for another file."""
