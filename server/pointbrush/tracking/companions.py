"""Labels that a run is not asked for: they are followed too, and nothing of them is reported.

Somebody who corrects one of several that look alike tracks that one again.  Alone it would take
what the others have, which a run of all of them had found to be theirs.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from pointbrush.tracking.interface import F32, I64, FrameResult, Seed
from pointbrush.tracking.options import CompanionOptions
from pointbrush.tracking.rules import FEWEST, FrameRules


class Companions:
    """Who goes along with the labels that are asked for."""

    def __init__(
        self, seeds: Sequence[Seed], rules: FrameRules, xyz: F32, options: CompanionOptions
    ) -> None:
        """``seeds`` are those asked for in the first frame ``xyz`` (N, 3) of a run.

        ``beginning`` are those who are labelled beside them there.
        """
        self._options = options
        self._asked = frozenset(seed.label for seed in seeds)
        self._size = options.larger * max(_size(xyz[seed.indices]) for seed in seeds)
        theirs = np.concatenate([seed.indices for seed in seeds])
        others = [Seed(n, np.setdiff1d(p, theirs)) for n, p in self._others(rules).items()]
        fitting = [seed for seed in others if self._fits(seed.indices, xyz)]
        away = [_distance(xyz[seed.indices], xyz[theirs]) for seed in fitting]
        self.beginning = [fitting[i] for i in np.argsort(away, kind="stable")[: options.most]]

    def known(self, rules: FrameRules, xyz: F32, followed: Collection[int]) -> dict[int, I64]:
        """Label → its points, of those who are known for sure in a frame.

        They are painted there, or the run may not take them.  Of those who are not ``followed`` yet
        the painted ones join.
        """
        known = {}
        room = self._options.most - len(set(followed) - self._asked)
        for n, points in self._others(rules).items():
            painted = rules.keyframe(n) is not None
            if n in followed:
                if painted or rules.untouched(n):
                    known[n] = points
            elif painted and room > 0 and self._fits(points, xyz):
                known[n] = points
                room -= 1
        return known

    def stored(self, rules: FrameRules, xyz: F32) -> dict[int, I64]:
        """Label → its points in a frame, of those of no greater size that an earlier run found."""
        others = self._others(rules)
        return {n: points for n, points in others.items() if self._fits(points, xyz)}

    def without(self, result: FrameResult) -> FrameResult:
        """A result of those that are asked for alone."""
        return replace(
            result,
            assignments={n: p for n, p in result.assignments.items() if n in self._asked},
            tracks={n: track for n, track in result.tracks.items() if n in self._asked},
        )

    def _others(self, rules: FrameRules) -> dict[int, I64]:
        return {n: points for n, points in rules.labelled().items() if n not in self._asked}

    def _fits(self, points: I64, xyz: F32) -> bool:
        return len(points) >= FEWEST and _size(xyz[points]) <= self._size


def _distance(some: F32, others: F32) -> float:
    """Metres between the middles of two clouds (M, 3) and (K, 3)."""
    if not len(others):
        return 0.0
    way = some.mean(axis=0, dtype=np.float64) - others.mean(axis=0, dtype=np.float64)
    return float(np.linalg.norm(way))


def _size(xyz: F32) -> float:
    """Metres across the box of some points (M, 3)."""
    return float(np.linalg.norm(np.ptp(xyz.astype(np.float64), axis=0))) if len(xyz) else 0.0
