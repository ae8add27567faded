"""Tracking across jumps of a sensor: detection of jumps, and registration over each jump."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np
from scipy import fft

from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import (
    F32,
    F64,
    ArrayFrame,
    FrameResult,
    Frames,
    Known,
    KnownSensor,
    Method,
    Seed,
    TrackFrame,
    TrackOptions,
    TrackState,
)
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.sensors import ScanOdometryOptions
from pointbrush.tracking.options.tracks import JumpOptions
from pointbrush.tracking.sensors.scan_odometry import Planes, in_place, planes_of, register
from pointbrush.tracking.sensors.trajectory import recorded_pose


@dataclass(frozen=True, slots=True, eq=False)
class Jump:
    """A jump of the sensor.

    ``at``: position in the order of the first frame after it; ``T`` (4, 4): motion of points from
    before the jump to after it.
    """

    at: int
    T: F64


def find_jumps(frames: Frames, order: Sequence[int], options: TrackerOptions) -> Iterator[Jump]:
    """Yield the jumps along ``order``; none if the recording has poses or the sensor moves."""
    if len(order) < 2 or _sensor_moves(frames, order, options=options.scan_odometry):
        return
    at, moving = 0, 0
    while at < len(order) - 1 and moving < options.jumps.patience:
        start = frames(order[at])
        to = min(at + options.jumps.stride_frames, len(order) - 1)
        if _stays(start, frames(order[to]), options.jumps):
            at = to
            continue
        before, after = at, to
        while after - before > 1:
            middle = (before + after) // 2
            if _stays(start, frames(order[middle]), options.jumps):
                before = middle
            else:
                after = middle
        T = _jump_between(frames, order, before, options)
        if T is None:
            at, moving = to, moving + 1
        else:
            yield Jump(after, T)
            at = after


def _sensor_moves(frames: Frames, order: Sequence[int], options: ScanOdometryOptions) -> bool:
    poses = [recorded_pose(frames(order[at]), options=options) for at in (0, len(order) // 2, -1)]
    known = [pose for pose in poses if pose is not None]
    return any(np.abs(pose - known[0]).max() > options.rest_pose for pose in known)


def _stays(one: TrackFrame, other: TrackFrame, options: JumpOptions) -> bool:
    """Return whether most points of one frame are at the same place in another."""
    xyz = np.asarray(one.xyz, np.float64)
    if not len(xyz) or not len(other.xyz):
        return True
    some = xyz[:: max(1, len(xyz) // options.sampled_points)]
    size = float(np.median(np.linalg.norm(some - np.median(some, axis=0), axis=1)))
    beside, _ = other.kdtree.query(
        np.asarray(other.xyz)[:: max(1, len(other.xyz) // options.sampled_points)], k=[2]
    )
    spacing = float(np.median(beside))
    reach = max(options.near_share * size, options.near_spacings * spacing)
    gap, _ = other.kdtree.query(some, distance_upper_bound=reach)
    return float(np.isfinite(gap).mean()) >= options.stays_share


def _jump_between(
    frames: Frames, order: Sequence[int], before: int, options: TrackerOptions
) -> F64 | None:
    """Return the motion (4, 4) of a jump after position ``before``, with rest on both sides."""
    beside = range(max(before - 1, 0), min(before + 3, len(order)))
    planes = {
        at: planes_of(np.asarray(frames(order[at]).xyz, np.float64), options=options)
        for at in beside
    }
    one, other = planes[before], planes[before + 1]
    if one is None or other is None:
        return None
    T = find_shift(one, other, options)
    if T is None:
        return None
    for first, second in ((before - 1, before), (before + 1, before + 2)):
        a, b = planes.get(first), planes.get(second)
        if a is None or b is None:
            continue
        step, _ = register(a, b.tree, np.eye(4), options=options.scan_odometry)
        if _displaced(a, step) > options.jumps.rest_share * _displaced(one, T):
            return None  # the sensor moves continuously
    return T


def find_shift(one: Planes, other: Planes, options: TrackerOptions) -> F64 | None:
    """Return the motion (4, 4) of a frame's surfaces to another; None: no motion or no match."""
    before = in_place(one, other.tree, np.eye(4), options=options.scan_odometry)
    best, share = np.eye(4), before
    for shift in _likely_shifts(one, other, options.jumps):
        start = np.eye(4)
        start[:3, 3] = shift
        T, found = register(one, other.tree, start, options=options.scan_odometry)
        if found > share:
            best, share = T, found
    odometry = options.scan_odometry
    better = share > odometry.agreed_share and 1 - share < odometry.left_share * (1 - before)
    return best if better and _displaced(one, best) > options.jumps.least_cells else None


def _displaced(planes: Planes, T: F64) -> float:
    """Return the median displacement of surfaces by ``T``, in cells."""
    if not len(planes.at):
        return 0.0
    moved = np.linalg.norm(transform(T, planes.at) - planes.at, axis=1)
    return float(np.median(moved)) / planes.cell


def _likely_shifts(one: Planes, other: Planes, options: JumpOptions) -> F64:
    """Return (K, 3) shifts in metres that align most surfaces with the same orientation."""
    side = options.side_pixels
    pixel = options.pixel_cells * max(one.cell, other.cell)
    middles = [np.median(planes.at, axis=0) for planes in (one, other)]
    product = np.zeros((side, side, side // 2 + 1), np.complex64)
    for axis in range(3):
        first, second = (
            fft.rfftn(_occupied(planes, axis, middle, pixel, side))
            for planes, middle in zip((one, other), middles, strict=True)
        )
        product += second * np.conj(first)
    likeness: F32 = np.asarray(fft.irfftn(product, s=(side,) * 3), np.float32)
    shifts = []
    for _ in range(options.shifts):
        peak = np.array(np.unravel_index(likeness.argmax(), likeness.shape))
        around = np.ix_(*((p + np.arange(-2, 3)) % side for p in peak))
        likeness[around] = -np.inf
        steps = (peak + side // 2) % side - side // 2
        shifts.append(steps * pixel + middles[1] - middles[0])
    return np.array(shifts)


def _occupied(planes: Planes, axis: int, middle: F64, pixel: float, side: int) -> F32:
    """Return a grid (side, side, side) of surfaces that face along an axis, with soft edges."""
    facing = np.abs(planes.normal).argmax(axis=1) == axis
    at = (planes.at[facing] - middle) / pixel
    at = np.rint(at[(np.abs(at) < side // 4).all(axis=1)]).astype(np.int64)
    image: F32 = np.zeros((side,) * 3, np.float32)
    image[tuple(at.T % side)] = 1.0
    # Surfaces at a pixel's border count in the neighbouring pixel too.
    for way in range(3):
        image += np.float32(0.5) * (np.roll(image, 1, way) + np.roll(image, -1, way))
    return image


def _moved(frame: TrackFrame, T: F64) -> ArrayFrame:
    """Return a frame with points moved by ``T`` (4, 4), which no sensor saw from a known place."""
    xyz = transform(T, np.asarray(frame.xyz, np.float64)).astype(np.float32)
    return ArrayFrame(xyz, None, rgb=frame.rgb, intensity=frame.intensity)


@dataclass(frozen=True)
class AcrossJumps:
    """``method``, restarted after each jump from the result of ``step``.

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
        """Track the last found labels into the frame after a jump; labels not found are absent."""
        before, after = order[jump.at - 1], order[jump.at]

        def moved(number: int) -> TrackFrame:
            return _moved(frames(number), jump.T) if number == before else frames(number)

        seeds = [Seed(n, points) for n, points in last.assignments.items() if len(points)]
        if not seeds:
            return FrameResult(after, {}, {})
        track_options = replace(options, before=(), continue_lost=True, sensor=KnownSensor())
        _, found = self.step.track(moved, [before, after], seeds, known, track_options)
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
    """Return a result with poses relative to the start, given ``poses`` of the first frame."""

    def from_start(label: int, track: TrackState) -> TrackState:
        first = poses.get(label)
        return track if first is None else replace(track, pose=track.pose @ first)

    tracks = {label: from_start(label, track) for label, track in result.tracks.items()}
    return replace(result, tracks=tracks)
