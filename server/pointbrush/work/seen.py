"""What of a frame can be pointed at: points that are neither deleted nor of a hidden label."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import LabelStore
from pointbrush.ranges import by_block

LAYER_BLOCK = 65_536
"""Points whose values are looked up at once."""
NONE: frozenset[int] = frozenset()


class Seen:
    """Tells points of one frame apart, as they are at each call; ``numbers`` are sorted.

    ``hidden``: labels that only the viewer hides, beside those that the palette hides; 0: points
    without a label.
    """

    def __init__(
        self, store: LabelStore, sequence: str, frame: int, hidden: frozenset[int] = NONE
    ) -> None:
        self._store, self._sequence, self._frame = store, sequence, frame
        self._hidden = hidden

    def shown(self, numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which of stored ``numbers`` (n,) rays meet and strokes change."""
        hidden = self._store.hidden(self._sequence).copy()
        hidden[list(self._hidden)] = True
        shown = np.zeros(len(numbers), np.bool_)
        for first, mine in by_block(numbers, LAYER_BLOCK):
            values = self._store.values(self._sequence, self._frame, first, LAYER_BLOCK)
            at = numbers[mine] - first
            shown[mine] = ~values.deleted[at] & ~hidden[values.label[at]]
        return shown

    def deleted(self, numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Which of stored ``numbers`` (n,) are deleted: what is restored."""
        deleted = np.zeros(len(numbers), np.bool_)
        for first, mine in by_block(numbers, LAYER_BLOCK):
            values = self._store.values(self._sequence, self._frame, first, LAYER_BLOCK)
            deleted[mine] = values.deleted[numbers[mine] - first]
        return deleted
