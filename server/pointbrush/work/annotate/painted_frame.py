"""One of the frames that a stroke paints: the points it sees, takes, and will change."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import View
from pointbrush.labels.types import PAINTED, FrameValues
from pointbrush.ranges import by_block
from pointbrush.selection import Points, PointSet, Stroke
from pointbrush.selection.points import Alive
from pointbrush.selection.selecting import Layer
from pointbrush.sequences import LARGE_POINTS, StoredFrame
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.overlays import Placement

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
        """Mark the stored ``numbers`` (n,) that rays meet and strokes change."""
        return self._among(numbers, deleted=False)

    def deleted(self, numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Mark the stored ``numbers`` (n,) that are deleted, and so can be restored."""
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


def frame_points(frame: StoredFrame, up: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Points:
    """Return the view of a stored frame that selection works on; ``up``: away from the ground."""
    levels = sorted({chunk.level: chunk.first for chunk in reversed(frame.chunks)}.items())
    large, many = frame.large, frame.count > LARGE_POINTS
    return Points(
        xyz=frame.coordinates,
        blocks=frame.blocks,
        rgb=frame.rgb,
        # An octree's nodes are not global levels: there each block stands for itself.
        levels=(0,) if many else tuple(first for _, first in levels) or (0,),
        kdtree=None if large else lambda: frame.kdtree,
        release=frame.release if large else None,
        up=up,
        pixels=frame.lattice,
    )


class PaintedFrame:
    """A frame under a stroke: the points it sees and takes; ``frame`` is its number."""

    def __init__(
        self, view: View, recording: Recording, placement: Placement, brush: Stroke
    ) -> None:
        self.frame, self._placement = placement.frame, placement
        self._recording, self._view, self._brush = recording, view, brush
        x, y, z = recording.manifest.T_room_local[1, :3].tolist()
        self._points = frame_points(recording[self.frame], (x, y, z))
        self._seen = Seen(view, self.frame, brush.hidden)
        self._touchable = self._seen.deleted if brush.tool == "restore" else self._seen.shown
        self._changing = Changing(view, self.frame, brush)
        self._labels: dict[int, NDArray[np.uint16]] = {}
        self.taken = PointSet()

    def layers(self) -> list[Layer]:
        """Return the frame's points that stand still, and those of each object that moves."""
        moving = self._placement.moving
        still = Layer(
            self._points,
            self._placement.T_shown_frame,
            self._touchable,
            self._labelled(frozenset(moving), among=False) if moving else None,
        )
        objects = [
            Layer(self._points, T, self._touchable, self._labelled(frozenset({label}), among=True))
            for label, T in moving.items()
        ]
        return [still, *objects]

    def _labelled(self, labels: frozenset[int], *, among: bool) -> Alive:
        """Say of stored numbers (n,) whether their label is ``among`` those, or is not."""
        wanted = np.array(sorted(labels), np.uint16)

        def part(numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
            found = np.zeros(len(numbers), np.bool_)
            for first, mine in by_block(numbers, LAYER_BLOCK):
                found[mine] = np.isin(self._label_block(first)[numbers[mine] - first], wanted)
            return found if among else ~found

        return part

    def _label_block(self, first: int) -> NDArray[np.uint16]:
        # As it was when the stroke first met it: what the stroke sees does not move under it.
        if first not in self._labels:
            values = self._view.values(self.frame, first, LAYER_BLOCK)
            self._labels[first] = values.label
        return self._labels[first]

    def look(self) -> None:
        """Raise DamagedError when the frame's files have been cut short."""
        self._recording[self.frame].look()

    def renew(self) -> None:
        """Look at the store again for what can be touched."""
        self._seen.renew()

    def take(self, numbers: NDArray[np.int64]) -> None:
        """Take in sorted stored numbers."""
        self._changing.add(self.taken.add(numbers))

    def clear(self) -> None:
        """Drop all points taken so far."""
        self.taken = PointSet()
        self._changing = Changing(self._view, self.frame, self._brush)

    @property
    def changing(self) -> int:
        """Count the points taken that the stroke will change."""
        return self._changing.count()

    def those_changing(self) -> NDArray[np.int64]:
        """Return stored numbers of the points taken that the stroke would change, ascending."""
        parts = [self._changing.those(numbers) for numbers in self.taken.parts()]
        return np.concatenate([np.empty(0, np.int64), *parts])
