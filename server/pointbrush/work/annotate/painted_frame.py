"""A frame that a stroke paints: its visible points, selected points and points to change."""

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
"""Number of points with values looked up at once."""
KEPT = 64
"""Limit of cached blocks, 64 kB each."""
FEW = 8_192
"""Limit of points that are looked up singly; for more, whole blocks are read and cached."""
NONE: frozenset[int] = frozenset()


class Seen:
    """Masks of points of one frame by sorted ``numbers``, as of the last call of ``renew``.

    They are needed for each ray, so values of up to ``KEPT`` blocks are cached.  ``hidden``: labels
    hidden only by the viewer, besides labels hidden by the palette; 0: points without a label.
    """

    def __init__(self, view: View, frame: int, hidden: frozenset[int] = NONE) -> None:
        self._view, self._frame = view, frame
        self._hidden = hidden
        self._masks: dict[tuple[int, bool], NDArray[np.bool_]] = {}

    def renew(self) -> None:
        """Update from the store."""
        self._view.look()
        self._masks.clear()

    def shown(self, numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return the mask of stored ``numbers`` (n,) that rays can hit and strokes can change."""
        return self._among(numbers, deleted=False)

    def deleted(self, numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return the mask of stored ``numbers`` (n,) that are deleted and can be restored."""
        return self._among(numbers, deleted=True)

    def _among(self, numbers: NDArray[np.int64], *, deleted: bool) -> NDArray[np.bool_]:
        if len(numbers) <= FEW:
            return self._of(self._view.at(self._frame, numbers), deleted=deleted)
        found = np.zeros(len(numbers), np.bool_)
        for first, mine in by_block(numbers, LAYER_BLOCK):
            found[mine] = self._mask(first, deleted=deleted)[numbers[mine] - first]
        return found

    def _mask(self, first: int, *, deleted: bool) -> NDArray[np.bool_]:
        """Return the mask of deleted, or of shown, points of a block."""
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

    The count is computed on demand.  For many points, blocks of values are read once per stroke;
    concurrent changes of others are included only in the exact count of the commit.
    """

    def __init__(self, view: View, frame: int, brush: Stroke) -> None:
        self._view, self._frame, self._brush = view, frame, brush
        self._blocks: dict[int, NDArray[np.bool_]] = {}
        self._waiting = PointSet()
        self._spared: NDArray[np.bool_] | None = None
        self._count = 0

    def add(self, numbers: NDArray[np.int64]) -> None:
        """Add sorted stored numbers that the stroke has newly touched."""
        self._waiting.add(numbers)

    def count(self) -> int:
        """Return the number of added points that will change."""
        waiting, self._waiting = self._waiting, PointSet()
        for numbers in waiting.parts():
            if len(numbers) <= FEW:
                found = self._changes(self._view.at(self._frame, numbers))
                self._count += int(np.count_nonzero(found))
                continue
            for first, mine in by_block(numbers, LAYER_BLOCK):
                self._count += int(np.count_nonzero(self._block(first)[numbers[mine] - first]))
        return self._count

    def changing_among(self, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the sorted stored numbers of (n,) that will change."""
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
        """Return for each label whether the brush does not change its points."""
        spared = np.zeros(1 << 16, np.bool_)
        restores = self._brush.tool == "restore"
        for label in self._view.palette().values():
            spared[label.id] = label.locked or not (label.visible or restores)
        if not restores:
            spared[list(self._brush.hidden)] = True
        return spared


def frame_points(frame: StoredFrame, up: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Points:
    """Return a stored frame as points for selection; ``up``: away from the ground."""
    levels = sorted({chunk.level: chunk.first for chunk in reversed(frame.chunks)}.items())
    large, many = frame.large, frame.count > LARGE_POINTS
    return Points(
        xyz=frame.coordinates,
        blocks=frame.blocks,
        rgb=frame.rgb,
        # The nodes of an octree are not global levels: each block is its own level.
        levels=(0,) if many else tuple(first for _, first in levels) or (0,),
        kdtree=None if large else lambda: frame.kdtree,
        release=frame.release if large else None,
        up=up,
        pixels=frame.lattice,
    )


def of_shown_sensors(frame: StoredFrame, hidden: frozenset[int]) -> Alive | None:
    """Return a mask function of stored numbers: points of sensors beside ``hidden``; None: all."""
    sensor = frame.sensor
    if sensor is None or not hidden:
        return None
    shown = np.ones(256, np.bool_)
    shown[list(hidden)] = False
    return lambda numbers: np.asarray(shown[sensor[numbers]])


def both(one: Alive, other: Alive | None) -> Alive:
    """Return a mask function of the points that both functions mark; None marks all."""
    return one if other is None else lambda numbers: one(numbers) & other(numbers)


class PaintedFrame:
    """A frame under a stroke: its visible and selected points; ``frame`` is its number."""

    def __init__(
        self, view: View, recording: Recording, placement: Placement, brush: Stroke
    ) -> None:
        self.frame, self._placement = placement.frame, placement
        self._recording, self._view, self._brush = recording, view, brush
        x, y, z = recording.manifest.T_room_local[1, :3].tolist()
        self._points = frame_points(recording[self.frame], (x, y, z))
        self._of_shown = of_shown_sensors(recording[self.frame], brush.hidden_sensors)
        self._seen = Seen(view, self.frame, brush.hidden)
        self._touchable = self._seen.deleted if brush.tool == "restore" else self._seen.shown
        self._changing = Changing(view, self.frame, brush)
        self._labels: dict[int, NDArray[np.uint16]] = {}
        self.taken = PointSet()

    def layers(self) -> list[Layer]:
        """Return a layer of the frame's static points, and one of each moving object."""
        moving = self._placement.moving
        rest = self._part(frozenset(moving), among=False) if moving else self._of_shown
        still = Layer(self._points, self._placement.T_shown_frame, self._touchable, rest)
        objects = [
            Layer(self._points, T, self._touchable, self._part(frozenset({label}), among=True))
            for label, T in moving.items()
        ]
        return [still, *objects]

    def _part(self, labels: frozenset[int], *, among: bool) -> Alive:
        """Return a mask function of points of shown sensors with a label in ``labels``, or not."""
        wanted = np.array(sorted(labels), np.uint16)

        def part(numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
            found = np.zeros(len(numbers), np.bool_)
            for first, mine in by_block(numbers, LAYER_BLOCK):
                found[mine] = np.isin(self._label_block(first)[numbers[mine] - first], wanted)
            return found if among else ~found

        return both(part, self._of_shown)

    def _label_block(self, first: int) -> NDArray[np.uint16]:
        # Read once per stroke, so that the layers do not change during the stroke.
        if first not in self._labels:
            values = self._view.values(self.frame, first, LAYER_BLOCK)
            self._labels[first] = values.label
        return self._labels[first]

    def look(self) -> None:
        """Raise DamagedError if the frame's files were truncated."""
        self._recording[self.frame].look()

    def renew(self) -> None:
        """Update the points that can be touched from the store."""
        self._seen.renew()

    def take(self, numbers: NDArray[np.int64]) -> None:
        """Select points by sorted stored numbers."""
        self._changing.add(self.taken.add(numbers))

    def clear(self) -> None:
        """Drop the selection."""
        self.taken = PointSet()
        self._changing = Changing(self._view, self.frame, self._brush)

    @property
    def changing(self) -> int:
        """Return the number of selected points that the stroke will change."""
        return self._changing.count()

    def changing_numbers(self) -> NDArray[np.int64]:
        """Return ascending stored numbers of the selected points that the stroke would change."""
        parts = [self._changing.changing_among(numbers) for numbers in self.taken.parts()]
        return np.concatenate([np.empty(0, np.int64), *parts])
