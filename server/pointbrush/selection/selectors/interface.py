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
"""Numbers of the points of a candidate, and its score: 0..1, the overlap that is expected."""


class StateLostError(UnavailableError):
    """A selector does not know a state any more: its frame must be prepared anew."""


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
        """Return at most six regions, the one to show first in front.

        ``positives`` (K, 3) and ``negatives`` (L, 3) are places on the surface, local metres;
        ``mask`` is what was taken so far.
        """


@runtime_checkable
class StoredSelector(Protocol):
    """A selector whose states are kept on disk, and made in a process of their own."""

    version: str
    """Of its states: those of another version are prepared anew."""

    def save(self, state: Any, path: Path) -> None:
        """Write a state to a file."""

    def load(self, path: Path) -> Any:
        """Read a file that ``save`` wrote; raises BadInputError for anything else."""
