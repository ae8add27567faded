"""Duplicate points in frames, from dual-return sensors and merged clouds.

A method sees each distinct point once, so that the spacing of an object is that of its distinct
points.  Its labels are applied to all copies of a point that the run may take.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.tracking.interface import (
    F32,
    I64,
    PAINTED,
    ArrayFrame,
    FrameKnowledge,
    FrameResult,
    Frames,
    Known,
    Seed,
    TrackFrame,
    TrackOptions,
)
from pointbrush.tracking.permissions import FrameRules

REMEMBERED = 16
"""Number of frames with cached copies: somewhat more than the lag of a method."""


@dataclass(frozen=True, slots=True, eq=False)
class Copies:
    """Copies in a frame of N points.

    ``first`` (M,): sorted indices of distinct points; ``position`` (N,): position in ``first`` of
    each point's distinct point.
    """

    first: I64
    position: I64

    @staticmethod
    def of(xyz: F32) -> Copies | None:
        """Return the copies among points (N, 3); None: all differ."""
        bits = (np.ascontiguousarray(xyz, np.float32) + np.float32(0.0)).view(np.uint32)
        first = _first_equal(bits)
        distinct = np.flatnonzero(first == np.arange(len(first)))
        if len(distinct) == len(first):
            return None
        return Copies(distinct, np.searchsorted(distinct, first))


class DistinctFrames:
    """Frame number → frame with each distinct point once; picklable if ``frames`` is."""

    def __init__(self, frames: Frames) -> None:
        self._frames = frames
        self._remembered = lru_cache(REMEMBERED)(self._found)
        self._without: set[int] = set()

    def __call__(self, number: int) -> TrackFrame:
        """Return a frame of distinct points; the frame itself if all are distinct."""
        frame, copies = self._frames(number), self.copies(number)
        return frame if copies is None else _only(frame, copies.first)

    def __reduce__(self) -> tuple[type[DistinctFrames], tuple[Frames]]:
        return DistinctFrames, (self._frames,)

    def copies(self, number: int) -> Copies | None:
        """Return the copies in a frame; None: all its points differ."""
        return None if number in self._without else self._remembered(number)

    def _found(self, number: int) -> Copies | None:
        copies = Copies.of(np.asarray(self._frames(number).xyz))
        if copies is None:
            self._without.add(number)
        return copies


@dataclass(frozen=True, eq=False)
class DistinctRun:
    """A call of a method in distinct points, with its results in all points."""

    frames: DistinctFrames
    whole: Known
    options: TrackOptions

    def seeds(self, start: int, seeds: Sequence[Seed]) -> list[Seed]:
        """Return seeds of frame ``start`` with each distinct point once."""
        copies = self.frames.copies(start)
        if copies is None:
            return list(seeds)
        return [Seed(seed.label, np.unique(copies.position[seed.indices])) for seed in seeds]

    def known(self, number: int) -> FrameKnowledge | None:
        """Return the knowledge of the distinct points of a frame.

        Of several copies the painted one counts, else a labelled one; a point is deleted if all its
        copies are.
        """
        know, copies = self.whole(number), self.frames.copies(number)
        if know is None or copies is None:
            return know
        rank = np.where(know.deleted, 0, 1 + (know.label > 0) + 2 * (know.provenance == PAINTED))
        order = np.lexsort((-rank, copies.position))
        _, at = np.unique(copies.position[order], return_index=True)
        chosen = order[at]
        return FrameKnowledge(know.label[chosen], know.provenance[chosen], know.deleted[chosen])

    def of_all(self, result: FrameResult, labels: Sequence[int]) -> FrameResult:
        """Return a result of distinct points extended to all copies that ``labels`` may take."""
        copies = self.frames.copies(result.frame)
        if copies is None:
            return result
        know = self.whole(result.frame)
        free = FrameRules(len(copies.position), know, self.options).free(labels)
        assignments, tracks = {}, dict(result.tracks)
        for label, distinct in result.assignments.items():
            has = np.zeros(len(copies.first), np.bool_)
            has[distinct] = True
            may = free if know is None else free | ((know.label == label) & ~know.deleted)
            assignments[label] = np.flatnonzero(has[copies.position] & may)
            if label in tracks:
                tracks[label] = replace(tracks[label], points=len(assignments[label]))
        return FrameResult(result.frame, assignments, tracks)


def _only(frame: TrackFrame, points: I64) -> ArrayFrame:
    """Return a frame of some points of another."""
    return ArrayFrame(
        np.asarray(frame.xyz)[points],
        frame.viewpoint,
        frame.pose,
        frame.lattice,
        None if frame.rgb is None else np.asarray(frame.rgb)[points],
        None if frame.intensity is None else np.asarray(frame.intensity)[points],
        None if frame.sensor is None else np.asarray(frame.sensor)[points],
        frame.parts,
    )


@compiled
def _first_equal(bits: NDArray[np.uint32]) -> I64:
    """Return (N,) the first equal row of each row (N, 3), by a hash table with open addressing."""
    size = 16
    while size < 2 * len(bits):
        size *= 2
    table, first = np.full(size, -1, np.int32), np.empty(len(bits), np.int64)
    for i in range(len(bits)):
        a, b, c = np.uint64(bits[i, 0]), np.uint64(bits[i, 1]), np.uint64(bits[i, 2])
        mixed = a * np.uint64(0x9E3779B97F4A7C15) + b * np.uint64(0xC2B2AE3D27D4EB4F)
        mixed = (mixed + c) * np.uint64(0x165667B19E3779F9)
        at = np.int64(mixed >> np.uint64(32)) & (size - 1)
        while True:
            other = table[at]
            if other < 0:
                table[at] = first[i] = i
                break
            if bits[other, 0] == a and bits[other, 1] == b and bits[other, 2] == c:
                first[i] = other
                break
            at = (at + 1) & (size - 1)
    return first
