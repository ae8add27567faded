"""Points that a run may take, and companion labels tracked along with the requested ones."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

import numpy as np

from pointbrush.tracking.interface import (
    F32,
    I64,
    PAINTED,
    FrameKnowledge,
    FrameResult,
    Known,
    Mask,
    Seed,
    TrackOptions,
)
from pointbrush.tracking.options.tracks import CompanionOptions

FEWEST = 10
"""Number of painted points below which a label does not count as painted in a frame."""


class FrameRules:
    """The rules of one frame of ``count`` points; ``taken`` grows as labels are assigned."""

    def __init__(self, count: int, knowledge: FrameKnowledge | None, options: TrackOptions) -> None:
        self.count = count
        self._knowledge = knowledge
        self._options = options
        self._taken = np.zeros(count, np.bool_)

    @property
    def _empty(self) -> bool:
        know = self._knowledge
        return know is None or not (know.label.any() or know.provenance.any() or know.deleted.any())

    def free(self, labels: Iterable[int]) -> Mask:
        """Return a mask (N,) of points that a run of ``labels`` may take and that are not taken."""
        know = self._knowledge
        free = ~self._taken
        if know is None or self._empty:
            return free
        mine = np.isin(know.label, list(labels)) & (know.label > 0)
        free &= ~know.deleted & ~np.isin(know.label, list(self._options.locked))
        if self._options.overwrite != "all":
            # Painted points keep their label, also if it is one of this run.
            free &= know.provenance != PAINTED
        if self._options.overwrite == "never":
            free &= mine | (know.label == 0)
        return free

    def anchors(self, label: int) -> I64:
        """Return the points painted with ``label``, which override the results of a method."""
        know = self._knowledge
        if know is None or self._options.overwrite == "all":
            return np.empty(0, np.int64)
        return np.flatnonzero((know.label == label) & (know.provenance == PAINTED) & ~know.deleted)

    def keyframe(self, label: int) -> I64 | None:
        """Return all points of ``label`` if a person painted it in this frame, else None."""
        if len(self.anchors(label)) < FEWEST or self._knowledge is None:
            return None
        return np.flatnonzero((self._knowledge.label == label) & ~self._knowledge.deleted)

    def labelled(self) -> dict[int, I64]:
        """Return the points by label, for labels with enough points."""
        if self._knowledge is None or self._empty:
            return {}
        label = np.where(self._knowledge.deleted, 0, self._knowledge.label)
        counts = np.bincount(label)
        counts[0] = 0
        return {n: np.flatnonzero(label == n) for n in np.flatnonzero(counts >= FEWEST).tolist()}

    def untouched(self, label: int) -> bool:
        """Return whether other labels may not take points of ``label``."""
        return self._options.overwrite == "never" or label in self._options.locked

    def take(self, indices: I64) -> None:
        """Mark points as taken."""
        self._taken[indices] = True


def keyframes(
    order: Iterable[int], labels: Iterable[int], known: Known, options: TrackOptions
) -> dict[int, list[int]]:
    """Return by label the positions in ``order``, except 0, of frames where a person painted it."""
    found: dict[int, list[int]] = {label: [] for label in labels}
    for position, number in enumerate(order):
        if not position or (options.painted is not None and number not in options.painted):
            continue
        know = known(number)
        if know is None or options.overwrite == "all":
            continue
        painted = know.label[(know.provenance == PAINTED) & ~know.deleted]
        counts = np.bincount(painted, minlength=1) if len(painted) else np.zeros(1, np.int64)
        for label, positions in found.items():
            if label < len(counts) and counts[label] >= FEWEST:
                positions.append(position)
    return found


class Companions:
    """Companion labels, tracked along with the requested ones."""

    def __init__(
        self, seeds: Sequence[Seed], rules: FrameRules, xyz: F32, options: CompanionOptions
    ) -> None:
        """``seeds``: requested labels in the first frame ``xyz`` (N, 3) of a run.

        ``beginning`` has the seeds of the nearest other labels there.
        """
        self._options = options
        self._requested = frozenset(seed.label for seed in seeds)
        self._size = options.larger * max(_size(xyz[seed.indices]) for seed in seeds)
        theirs = np.concatenate([seed.indices for seed in seeds])
        others = [Seed(n, np.setdiff1d(p, theirs)) for n, p in self._others(rules).items()]
        fitting = [seed for seed in others if self._fits(seed.indices, xyz)]
        distance = [_distance(xyz[seed.indices], xyz[theirs]) for seed in fitting]
        self.beginning = [fitting[i] for i in np.argsort(distance, kind="stable")[: options.most]]

    def known(self, rules: FrameRules, xyz: F32, followed: Collection[int]) -> dict[int, I64]:
        """Return by label the certain points of companions in a frame.

        Their points are painted there, or the run may not take them.  Of labels not ``followed``
        yet, only painted ones are added.
        """
        known = {}
        room = self._options.most - len(set(followed) - self._requested)
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
        """Return by label the stored points of companions in a frame, within the limit of size."""
        others = self._others(rules)
        return {n: points for n, points in others.items() if self._fits(points, xyz)}

    def without(self, result: FrameResult) -> FrameResult:
        """Return a result with only the requested labels."""
        return replace(
            result,
            assignments={n: p for n, p in result.assignments.items() if n in self._requested},
            tracks={n: track for n, track in result.tracks.items() if n in self._requested},
        )

    def _others(self, rules: FrameRules) -> dict[int, I64]:
        return {n: points for n, points in rules.labelled().items() if n not in self._requested}

    def _fits(self, points: I64, xyz: F32) -> bool:
        return len(points) >= FEWEST and _size(xyz[points]) <= self._size


def _distance(some: F32, others: F32) -> float:
    """Return the distance (m) between the middles of two clouds (M, 3) and (K, 3)."""
    if not len(others):
        return 0.0
    way = some.mean(axis=0, dtype=np.float64) - others.mean(axis=0, dtype=np.float64)
    return float(np.linalg.norm(way))


def _size(xyz: F32) -> float:
    """Return the size (m) of the bounding box of some points (M, 3)."""
    return float(np.linalg.norm(np.ptp(xyz.astype(np.float64), axis=0))) if len(xyz) else 0.0
