"""One of the frames that a stroke paints: its points in layers, and what is taken of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import View
from pointbrush.ranges import by_block
from pointbrush.selection import Points, PointSet, Stroke
from pointbrush.selection.ray import Alive
from pointbrush.selection.selecting import Layer
from pointbrush.sequences import LARGE_POINTS, StoredFrame
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.changing import Changing
from pointbrush.work.annotate.placing import Placement
from pointbrush.work.annotate.seen import LAYER_BLOCK, Seen


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
        self._recording, self._view = recording, view
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

    @property
    def changing(self) -> int:
        """Count the points taken that the stroke will change."""
        return self._changing.count()

    def those_changing(self) -> NDArray[np.int64]:
        """Return stored numbers of the points taken that the stroke would change, ascending."""
        parts = [self._changing.those(numbers) for numbers in self.taken.parts()]
        return np.concatenate([np.empty(0, np.int64), *parts])
