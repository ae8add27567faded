"""Tracking across jumps of a sensor: one run before, one after, and a registration between them.

Wraps a method that takes a sensor to rest or to move evenly.  At a jump (sensor/jumps.py) the
points that each label had in the last frame are moved along with the scenery, registered to the
first frame after it, and tracked on from there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.tracking.geometry.registration import transform
from pointbrush.tracking.interface import (
    F32,
    F64,
    FrameResult,
    Frames,
    Known,
    Method,
    Seed,
    TrackFrame,
    TrackOptions,
    TrackState,
)
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensor.jumps import Jump, find_jumps


@dataclass(frozen=True, eq=False)
class MovedFrame:
    """A ``TrackFrame`` whose points were moved by ``T`` (4, 4)."""

    still: TrackFrame
    T: F64

    @cached_property
    def xyz(self) -> F32:
        """(N, 3) positions."""
        return transform(self.T, np.asarray(self.still.xyz, np.float64)).astype(np.float32)

    @cached_property
    def kdtree(self) -> cKDTree:
        """A tree over the moved points."""
        return cKDTree(self.xyz, balanced_tree=False)

    @property
    def rgb(self) -> NDArray[np.uint8] | None:
        """(N, 3) colours."""
        return self.still.rgb

    @property
    def intensity(self) -> F32 | None:
        """(N,) intensities."""
        return self.still.intensity

    @property
    def viewpoint(self) -> F64 | None:
        """Sensor position: where it is after the jump, it did not see this frame."""
        return None

    @property
    def pose(self) -> F64 | None:
        """``T_world_frame``: not known."""
        return None


@dataclass(frozen=True)
class AcrossJumps:
    """``method``, begun anew behind each jump with what ``step`` finds there.

    ``step`` tracks from one frame to the next.
    """

    method: Method
    step: Method
    options: TrackerOptions = field(default_factory=TrackerOptions)

    def track(
        self,
        frames: Frames,
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,
        options: TrackOptions,
    ) -> Iterator[FrameResult]:
        """See ``Method.track``."""
        begin, seeds = 0, list(seeds)
        # T_frame_start of each label at the first frame of a run.
        poses = {seed.label: np.eye(4) for seed in seeds}
        for jump in chain(find_jumps(frames, order, self.options), [None]):
            last = FrameResult(order[begin], {s.label: s.indices for s in seeds}, {})
            part = order[begin : None if jump is None else jump.at]
            for number, result in enumerate(self.method.track(frames, part, seeds, known, options)):
                found = _composed(result, poses)
                if number or begin == 0:
                    yield found
                last = found if number else replace(found, assignments=last.assignments)
            if jump is None:
                return
            across = self._over(frames, order, jump, last, known, options)
            yield across
            begin, options = jump.at, replace(options, before=())
            seeds = [Seed(n, points) for n, points in across.assignments.items()]
            poses = {seed.label: across.tracks[seed.label].pose for seed in seeds}
            if not seeds:
                yield from (FrameResult(number, {}, {}) for number in order[begin + 1 :])
                return

    def _over(
        self,
        frames: Frames,
        order: Sequence[int],
        jump: Jump,
        last: FrameResult,
        known: Known,
        options: TrackOptions,
    ) -> FrameResult:
        """What was found last, in the frame behind a jump; labels that are not found are absent."""
        before, after = order[jump.at - 1], order[jump.at]

        def moved(number: int) -> TrackFrame:
            return MovedFrame(frames(number), jump.T) if number == before else frames(number)

        seeds = [Seed(n, points) for n, points in last.assignments.items() if len(points)]
        if not seeds:
            return FrameResult(after, {}, {})
        asked = replace(options, before=(), continue_lost=True)
        _, found = self.step.track(moved, [before, after], seeds, known, asked)
        tracks = {}
        for label, track in found.tracks.items():
            if label in found.assignments and len(found.assignments[label]):
                pose = track.pose @ jump.T @ _pose_of(last, label)
                sure = min(track.confidence, self.options.jumps.sure)
                tracks[label] = replace(track, pose=pose, confidence=sure)
        kept = {label: points for label, points in found.assignments.items() if label in tracks}
        return FrameResult(after, kept, tracks)


def _pose_of(result: FrameResult, label: int) -> F64:
    track = result.tracks.get(label)
    return np.eye(4) if track is None else track.pose


def _composed(result: FrameResult, poses: Mapping[int, F64]) -> FrameResult:
    """A result of a run whose labels had ``poses`` in its first frame."""

    def whole(label: int, track: TrackState) -> TrackState:
        first = poses.get(label)
        return track if first is None else replace(track, pose=track.pose @ first)

    tracks = {label: whole(label, track) for label, track in result.tracks.items()}
    return replace(result, tracks=tracks)
