"""Where labelled things were last seen: who was passed by stands there again, just as deep.

Of somebody who never goes away the scene behind is never seen, so that nothing tells that he stands
before it.  But what was his, and shows again as deep as it was, is he: no scenery, and nobody else.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.interface import F32, I64, Mask
from pointbrush.tracking.options import BackgroundOptions
from pointbrush.tracking.sensor.lens import I32


class LastSeen(NamedTuple):
    """The farthest ``label`` of each cell, 0 for none, and its ``depth`` when it was last seen.

    Arrays (cells + 1,), changed in place as frames are learnt.  A cell keeps its label while
    something nearer hides it, and gives it up when it shows what lies behind, or the thing is seen
    elsewhere.
    """

    label: I32
    depth: F32

    @staticmethod
    def nothing(count: int) -> LastSeen:
        """No label in any of so many cells."""
        return LastSeen(np.zeros(count, np.int32), np.full(count, np.nan, np.float32))

    def learn(
        self, seen: F32, owner: I32, limit: F32, known: F32, options: BackgroundOptions
    ) -> Mask:
        """Take in a frame; which cells show without a label what was labelled there.

        ``seen`` depths and ``owner`` labels of the cells, ``limit`` metres within which a depth is
        the same, ``known`` depths of the scene, NaN where it was never seen.
        """
        return _learnt(self, seen, owner, limit, known, options.stayed_share)

    def again(self, cell: I32, depth: F32, limit: F32) -> I64:
        """(M,) label that was as deep as that in the cells (M,), 0 for none."""
        same = np.abs(depth - self.depth[cell]) < limit
        return np.where(same, self.label[cell], 0).astype(np.int64)


@compiled
def _learnt(
    last: LastSeen, seen: F32, owner: I32, limit: F32, known: F32, stayed_share: float
) -> Mask:
    label, depth = last
    gone = _gone(last, seen, owner, limit, stayed_share)
    missed = np.zeros(len(seen), np.bool_)
    for c in range(len(seen)):
        if label[c] != 0 and gone[label[c]]:
            label[c] = 0
        if np.isnan(seen[c]) or (owner[c] == 0 and label[c] == 0):
            continue
        step = seen[c] - depth[c]
        if label[c] != 0 and step > limit[c]:
            label[c] = 0
        if seen[c] > known[c] - limit[c]:
            label[c] = 0
        elif owner[c] != 0 and (label[c] == 0 or label[c] == owner[c]):
            label[c], depth[c] = owner[c], seen[c]
        elif owner[c] == 0 and label[c] != 0:
            missed[c] = step > -limit[c]
    return missed


@compiled
def _gone(last: LastSeen, seen: F32, owner: I32, limit: F32, stayed_share: float) -> Mask:
    """(labels,) which are seen, and mostly elsewhere than before."""
    label, depth = last
    most = 0
    for c in range(len(seen)):
        most = max(most, label[c], owner[c])
    every, same = np.zeros(most + 1, np.int64), np.zeros(most + 1, np.int64)
    for c in range(len(seen)):
        every[owner[c]] += 1
        if owner[c] == label[c] and abs(seen[c] - depth[c]) < limit[c]:
            same[owner[c]] += 1
    return same < stayed_share * every
