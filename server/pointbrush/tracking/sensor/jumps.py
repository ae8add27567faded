"""Jumps of a sensor that is at rest otherwise, as frames without poses show them.

A tripod that was knocked or carried on, or two takes in one recording: between two frames all of
the scenery lies elsewhere.  Where it went is found by correlating the surfaces of the two frames,
each of the three ways that they face by itself, and by registering them from the best shifts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import fft

from pointbrush.tracking.geometry.registration import transform
from pointbrush.tracking.interface import F32, F64, Frames, TrackFrame
from pointbrush.tracking.options import JumpOptions, ScanOdometryOptions, TrackerOptions
from pointbrush.tracking.sensor.ego_motion import Planes, in_place, planes_of, register
from pointbrush.tracking.sensor.trajectory import recorded_pose


@dataclass(frozen=True, slots=True, eq=False)
class Jump:
    """``at`` is the position in the order of the first frame after it, ``T`` (4, 4) takes points
    of the frame before to where they lie after it."""

    at: int
    T: F64


def find_jumps(frames: Frames, order: Sequence[int], options: TrackerOptions) -> Iterator[Jump]:
    """Yield the jumps along ``order``; none where the recording tells poses or the sensor moves."""
    if len(order) < 2 or _told(frames, order, options=options.scan_odometry):
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


def _told(frames: Frames, order: Sequence[int], options: ScanOdometryOptions) -> bool:
    poses = [recorded_pose(frames(order[at]), options=options) for at in (0, len(order) // 2, -1)]
    known = [pose for pose in poses if pose is not None]
    return any(np.abs(pose - known[0]).max() > options.rest_pose for pose in known)


def _stays(one: TrackFrame, other: TrackFrame, options: JumpOptions) -> bool:
    """Whether most of what one frame shows is there in another."""
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
    """The jump from position ``before`` to the next, where the sensor rests beside it."""
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
            return None  # it moves all the time
    return T


def find_shift(one: Planes, other: Planes, options: TrackerOptions) -> F64 | None:
    """Where the surfaces of a frame lie in another (4, 4); None where they are where they were, or
    are not found."""
    before = in_place(one, other.tree, np.eye(4), options=options.scan_odometry)
    best, share = np.eye(4), before
    for shift in _likely(one, other, options.jumps):
        start = np.eye(4)
        start[:3, 3] = shift
        T, found = register(one, other.tree, start, options=options.scan_odometry)
        if found > share:
            best, share = T, found
    better = share > options.jumps.agreed_share and 1 - share < options.jumps.left_share * (
        1 - before
    )
    return best if better and _displaced(one, best) > options.jumps.least_cells else None


def _displaced(planes: Planes, T: F64) -> float:
    """Cells by which ``T`` displaces surfaces, at the median."""
    if not len(planes.at):
        return 0.0
    moved = np.linalg.norm(transform(T, planes.at) - planes.at, axis=1)
    return float(np.median(moved)) / planes.cell


def _likely(one: Planes, other: Planes, options: JumpOptions) -> F64:
    """(K, 3) metres, the shifts under which most surfaces that face alike lie on each other."""
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
    """(side, side, side) where surfaces lie that face along an axis, with soft edges."""
    facing = np.abs(planes.normal).argmax(axis=1) == axis
    at = (planes.at[facing] - middle) / pixel
    at = np.rint(at[(np.abs(at) < side // 4).all(axis=1)]).astype(np.int64)
    image: F32 = np.zeros((side,) * 3, np.float32)
    image[tuple(at.T % side)] = 1.0
    # A surface an edge of a pixel off still counts.
    for way in range(3):
        image += np.float32(0.5) * (np.roll(image, 1, way) + np.roll(image, -1, way))
    return image
