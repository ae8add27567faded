"""The built-in selector: the merge tree of ``pointbrush.selection.objects``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.objects import ObjectFrame, ObjectState, candidates, prepare
from pointbrush.selection.objects.state import VERSION
from pointbrush.selection.selectors.interface import Mask, Region


class TreeSelector:
    """A ``StoredSelector`` without external dependencies."""

    version = f"tree-{VERSION}"

    def prepare(self, frame: ObjectFrame) -> ObjectState:
        """Return cells, pieces and merge tree of a frame."""
        return prepare(frame)

    def candidates(
        self,
        state: ObjectState,
        positives: NDArray[np.float64],
        negatives: NDArray[np.float64],
        mask: Mask | None,
    ) -> Sequence[Region]:
        """Return nested regions from part to group; see ``Selector``."""
        found = candidates(state, positives, negatives, mask)
        return [(each.indices, each.score) for each in found]

    def save(self, state: ObjectState, path: Path) -> None:
        """Write a state to a file."""
        state.save(path)

    def load(self, path: Path) -> ObjectState:
        """Read a state; raises BadInputError for anything else."""
        return ObjectState.load(path)
