"""Background model without depth images (lidar, moving sensors).

The unlabelled points of earlier frames, aligned by their poses, in their stored k-d trees.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.compute.grid import bounds, close_to, within
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.view import View


@dataclass(eq=False)
class PointBackground:
    """Background of unlabelled points of earlier frames, searched by their k-d trees."""

    options: TrackerOptions
    reach: Callable[[F32], F32]
    """Function of world points (M, 3): (M,) metres within which points are equal."""
    past: list[tuple[View, Mask]] = field(default_factory=list)

    def static(self, view: View, indices: I64) -> tuple[Mask, Mask]:
        """See ``Background``."""
        return self._seen_in(self.past, view, indices), np.zeros(len(indices), np.bool_)

    def _seen_in(self, past: Sequence[tuple[View, Mask]], view: View, indices: I64) -> Mask:
        """Mark the points (M,) that occur unlabelled in a ``past`` frame."""
        world = view.xyz[indices]
        still = np.zeros(len(indices), np.bool_)
        reach = self.reach(world)
        for earlier, labelled in past:
            rest = np.flatnonzero(~still)
            T = earlier.T_world_frame
            at: F64 = world[rest].astype(np.float64)
            if T is not None:
                at = (at - T[:3, 3]) @ T[:3, :3]
            distance, index = earlier.frame.kdtree.query(
                at, distance_upper_bound=float(reach.max(initial=0.0)) + 1e-6
            )
            found = np.asarray(index) < len(labelled)
            near = found & (np.asarray(distance) < reach[rest])
            near[found] &= ~labelled[np.asarray(index)[found]]
            still[rest[near]] = True
        return still

    def _widen(self, view: View, labelled: Mask, some: NDArray[np.floating]) -> None:
        """Mark possibly missed points beside ``some`` (M, 3) object points as ``labelled``."""
        if not len(some):
            return
        reach = float(self.options.background.rim_reaches * self.reach(some[:1])[0])
        lo, hi = bounds(some)
        rest = np.flatnonzero(~labelled & within(view.xyz, lo - reach, hi + reach))
        labelled[rest[close_to(view.xyz[rest], some, reach)]] = True

    def scenery(self, _view: View, indices: I64, _frames: int) -> Mask:
        """See ``Background``; unknown without a depth image."""
        return np.zeros(len(indices), np.bool_)

    def certain(self, _view: View, indices: I64) -> Mask:
        """See ``Background``; the scene behind is unknown without a depth image."""
        return np.zeros(len(indices), np.bool_)

    def faint(self, view: View, indices: I64) -> Mask:
        """See ``Background``; in lidar scans, points that the painted frame does not rule out."""
        if not view.scans:
            return np.zeros(len(indices), np.bool_)
        return ~self._seen_in(self.past[:1], view, indices)

    def reappearing_labels(self, _view: View, indices: I64) -> I64:
        """See ``Background``; unknown without a depth image."""
        return np.zeros(len(indices), np.int64)

    def learn(self, view: View, first: bool = False, keep: F64 | None = None) -> None:
        """See ``Background``; keeps the first frame and two later ones."""
        if len(view.xyz) == 0:
            return
        labelled = view.labelled()
        if not first:
            own = view.xyz[labelled]
            self._widen(view, labelled, own if keep is None else np.vstack([own, keep]))
        entry = (view, labelled)
        if first or not self.past:
            self.past = [entry]
        elif len(self.past) < self.options.background.kept_scans:
            self.past.append(entry)
        else:
            self.past = [self.past[0], self.past[-1], entry]
