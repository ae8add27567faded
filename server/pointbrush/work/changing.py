"""While a stroke is drawn: how many points it will change, for the hand to feel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import LabelStore
from pointbrush.labels.types import PAINTED, FrameValues
from pointbrush.selection import Stroke

LAYER_BLOCK = 65_536
"""Points whose values are looked up at once."""


class Changing:
    """Counts the points that a brush will change in one frame.

    Each block of values is read once and kept for the stroke: what somebody else changes in the
    same second shows in the commit's own count, which is exact.
    """

    def __init__(self, store: LabelStore, sequence: str, frame: int, brush: Stroke) -> None:
        self._store, self._sequence, self._frame, self._brush = store, sequence, frame, brush
        self._blocks: dict[int, NDArray[np.bool_]] = {}
        self._locked = [label.id for label in store.palette(sequence) if label.locked]
        self.count = 0

    def add(self, numbers: NDArray[np.int64]) -> None:
        """Take in stored numbers that the stroke has newly touched."""
        blocks = numbers // LAYER_BLOCK
        for block in np.unique(blocks).tolist():
            if block not in self._blocks:
                values = self._store.values(
                    self._sequence, self._frame, block * LAYER_BLOCK, LAYER_BLOCK
                )
                self._blocks[block] = self._changes(values)
            mine = numbers[blocks == block] - block * LAYER_BLOCK
            self.count += int(np.count_nonzero(self._blocks[block][mine]))

    def _changes(self, values: FrameValues) -> NDArray[np.bool_]:
        """Which points of a block the brush would change: the rules of ``Write``."""
        brush, free = self._brush, ~np.isin(values.label, self._locked)
        if brush.tool == "restore":
            return np.asarray(values.deleted & free)
        changes = ~values.deleted & free
        if brush.tool == "erase":
            return np.asarray(changes & (values.label != 0))
        if brush.only_unlabeled:
            changes &= values.label == 0
        if brush.tool == "paint":
            changes &= (values.label != brush.label) | (values.provenance != PAINTED)
        return np.asarray(changes)
