"""While a stroke is drawn: how many points it will change, for the hand to feel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import View
from pointbrush.labels.types import PAINTED, FrameValues
from pointbrush.ranges import by_block
from pointbrush.selection import PointSet, Stroke
from pointbrush.work.annotate.seen import FEW, LAYER_BLOCK


class Changing:
    """Counts the points that a brush will change in one frame.

    It is done when somebody asks.  Many points' blocks of values are read once and kept for the
    stroke: what somebody else changes in the same second shows in the commit's own count, which is
    exact.
    """

    def __init__(self, view: View, frame: int, brush: Stroke) -> None:
        self._view, self._frame, self._brush = view, frame, brush
        self._blocks: dict[int, NDArray[np.bool_]] = {}
        self._waiting = PointSet()
        self._spared: NDArray[np.bool_] | None = None
        self._count = 0

    def add(self, numbers: NDArray[np.int64]) -> None:
        """Take in stored numbers that the stroke has newly touched, sorted."""
        self._waiting.add(numbers)

    def count(self) -> int:
        """Count the points taken in so far that will change."""
        waiting, self._waiting = self._waiting, PointSet()
        for numbers in waiting.parts():
            if len(numbers) <= FEW:
                found = self._changes(self._view.at(self._frame, numbers))
                self._count += int(np.count_nonzero(found))
                continue
            for first, mine in by_block(numbers, LAYER_BLOCK):
                self._count += int(np.count_nonzero(self._block(first)[numbers[mine] - first]))
        return self._count

    def those(self, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return those of sorted stored numbers (n,) that will change."""
        changes = [
            numbers[mine][self._block(first)[numbers[mine] - first]]
            for first, mine in by_block(numbers, LAYER_BLOCK)
        ]
        return np.concatenate([np.empty(0, np.int64), *changes])

    def _block(self, first: int) -> NDArray[np.bool_]:
        if first not in self._blocks:
            values = self._view.values(self._frame, first, LAYER_BLOCK)
            self._blocks[first] = self._changes(values)
        return self._blocks[first]

    def _changes(self, values: FrameValues) -> NDArray[np.bool_]:
        """Return the points of a block that the brush would change, by the rules of ``Write``."""
        if self._spared is None:
            self._spared = self._labels_spared()
        brush, free = self._brush, ~self._spared[values.label]
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

    def _labels_spared(self) -> NDArray[np.bool_]:
        """For each label, whether the brush leaves its points alone."""
        spared = np.zeros(1 << 16, np.bool_)
        restores = self._brush.tool == "restore"
        for label in self._view.palette().values():
            spared[label.id] = label.locked or not (label.visible or restores)
        if not restores:
            spared[list(self._brush.hidden)] = True
        return spared
