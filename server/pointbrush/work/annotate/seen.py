"""Points of a frame that can be pointed at: neither deleted nor of a hidden label."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import View
from pointbrush.labels.types import FrameValues
from pointbrush.ranges import by_block

LAYER_BLOCK = 65_536
"""Points whose values are looked up at once."""
KEPT = 64
"""Blocks that are kept, 64 kB each."""
FEW = 8_192
"""Points that are looked up one by one; of more their whole blocks are, and kept."""
NONE: frozenset[int] = frozenset()


class Seen:
    """Tells points of one frame apart, as they were when ``renew`` was called; sorted ``numbers``.

    Each ray asks: what was read of the store is kept in between, of ``KEPT`` blocks at most.

    ``hidden``: labels that only the viewer hides, beside those that the palette hides; 0: points
    without a label.
    """

    def __init__(self, view: View, frame: int, hidden: frozenset[int] = NONE) -> None:
        self._view, self._frame = view, frame
        self._hidden = hidden
        self._masks: dict[tuple[int, bool], NDArray[np.bool_]] = {}

    def renew(self) -> None:
        """Look at the store again."""
        self._view.look()
        self._masks.clear()

    def shown(self, numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which of stored ``numbers`` (n,) rays meet and strokes change."""
        return self._among(numbers, deleted=False)

    def deleted(self, numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which of stored ``numbers`` (n,) are deleted, and so can be restored."""
        return self._among(numbers, deleted=True)

    def _among(self, numbers: NDArray[np.int64], *, deleted: bool) -> NDArray[np.bool_]:
        if len(numbers) <= FEW:
            return self._of(self._view.at(self._frame, numbers), deleted=deleted)
        found = np.zeros(len(numbers), np.bool_)
        for first, mine in by_block(numbers, LAYER_BLOCK):
            found[mine] = self._mask(first, deleted=deleted)[numbers[mine] - first]
        return found

    def _mask(self, first: int, *, deleted: bool) -> NDArray[np.bool_]:
        """Return the points of a block that are deleted, or that are shown, as a mask."""
        mask = self._masks.get((first, deleted))
        if mask is None:
            values = self._view.values(self._frame, first, LAYER_BLOCK)
            mask = self._of(values, deleted=deleted)
            if len(self._masks) >= KEPT:
                self._masks.clear()
            self._masks[first, deleted] = mask
        return mask

    def _of(self, values: FrameValues, *, deleted: bool) -> NDArray[np.bool_]:
        if deleted:
            return values.deleted
        hidden = self._view.hidden()[values.label]
        if self._hidden:
            hidden |= np.isin(values.label, list(self._hidden))
        return np.asarray(~values.deleted & ~hidden)
