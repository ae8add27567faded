"""Cached features of frames, computed once and evicted when the cache is full."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.classify.features import Described, describe, scale_of
from pointbrush.errors import TooLargeError
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.painted_frame import frame_points
from pointbrush.work.classifiers.frames import example_frame
from pointbrush.work.classifiers.options import ClassifierOptions
from pointbrush.work.objects.frames import near

Numbers = NDArray[np.int64]
Key = tuple[str, int, float, tuple[int, ...]]
SAMPLED = 1_000_000
"""Number of points of a piece from which the scale of a large frame is computed."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Part of a frame with a unique ``key``: its points ``members``; ``describe`` is slow."""

    key: Key
    members: Numbers
    describe: Callable[[], Described]


class DescribedFrames:
    """Cells and features of frames, or of parts of large ones; thread-safe."""

    def __init__(self, options: ClassifierOptions) -> None:
        self._options = options
        self._kept: Cache[Key, tuple[Described, Numbers]] = Cache(options.memory_bytes)
        self._busy = threading.Lock()

    def scale(self, recording: Recording, frame: int) -> float:
        """Return the size of a cell for frames like this one."""
        stored, members = recording[frame], None
        if stored.count > self._options.whole_points:
            middle = np.asarray(stored.coordinates[np.arange(1)], np.float64)[0]
            members = near(frame_points(stored), middle, 1e5, SAMPLED)
        return scale_of(example_frame(recording, frame, members).xyz, self._options.features)

    def whole(self, recording: Recording, frame: int, size: float) -> Described:
        """Return a frame's features; raises TooLargeError for a frame that is read in pieces."""
        count = recording[frame].count
        if count > self._options.whole_points:
            raise TooLargeError(
                f"frame {frame}: expected at most {self._options.whole_points:,} points, or a "
                f"place in it, got {count:,}"
            )
        return self._get(recording, frame, size, (), None)[0]

    def round(
        self, recording: Recording, frame: int, size: float, place: NDArray[np.float64]
    ) -> tuple[Described, Numbers]:
        """Return the features of points near a place (3,), local metres, and their numbers."""
        stored = recording[frame]
        if stored.count <= self._options.whole_points:
            return self.whole(recording, frame, size), np.arange(stored.count)
        cube, members = self._near(recording, frame, size, place, self._options.view_points)
        return self._get(recording, frame, size, cube, members)

    def holding(
        self, recording: Recording, frame: int, size: float, points: Numbers
    ) -> Iterator[Part]:
        """Yield the distinct parts of a frame that contain ``points`` (n,)."""
        stored = recording[frame]
        if stored.count <= self._options.whole_points:
            whole = partial(self.whole, recording, frame, size)
            yield Part((recording.placement, frame, size, ()), np.arange(stored.count), whole)
            return
        left = points
        while len(left):
            place = np.asarray(stored.coordinates[left[:1]], np.float64)[0]
            cube, members = self._near(recording, frame, size, place, self._options.taught_points)
            made = partial(self._describe, recording, frame, size, members)
            yield Part((recording.placement, frame, size, cube), members, made)
            left = left[1:][~np.isin(left[1:], members, kind="sort")]

    def _near(
        self, recording: Recording, frame: int, size: float, place: NDArray[np.float64], most: int
    ) -> tuple[tuple[int, ...], Numbers]:
        """Return the cube that contains a place, and about ``most`` points around its centre."""
        step = 64 * size
        cube = np.floor(place / step)
        members = near(frame_points(recording[frame]), (cube + 0.5) * step, 1e5, most)
        return tuple(cube.astype(int).tolist()), members

    def _describe(
        self, recording: Recording, frame: int, size: float, members: Numbers | None
    ) -> Described:
        made = example_frame(recording, frame, members)
        return describe(made, size, self._options.features)

    def forget(self, identity: str) -> None:
        """Drop the cache of a recording, by its import's identity."""
        for key in self._kept.held():
            if key[0] == identity:
                self._kept.drop(key)

    def _get(
        self, recording: Recording, frame: int, size: float, cube: tuple[int, ...],
        members: Numbers | None,
    ) -> tuple[Described, Numbers]:  # fmt: skip
        key = (recording.placement, frame, size, cube)
        known = self._kept.known(key)
        if known is not None:
            return known
        with self._busy:  # one at a time, so that no frame is processed twice
            known = self._kept.known(key)
            if known is None:
                made = self._describe(recording, frame, size, members)
                kept = np.empty(0, np.int64) if members is None else members
                known = made, kept
                self._kept.get(key, lambda: (made, kept), made.nbytes + kept.nbytes)
        return known
