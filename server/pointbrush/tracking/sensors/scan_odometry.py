"""Poses of a lidar by registration of planes of the scene from scan to scan."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from pointbrush.tracking.compute.deformation import nodes_of
from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import F64, I64, Frames, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.sensors import ScanOdometryOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.scanner import find_eye, reach_of
from pointbrush.tracking.sensors.trajectory import (
    Motion,
    RecordedTrajectory,
    RegisteredTrajectory,
    Trajectory,
    recorded_pose,
)
from pointbrush.tracking.sensors.visual_odometry import CameraTrajectory, camera_motions, framed


def likely_shifts(
    before: F64, after: F64, cell: float, count: int, options: ScanOdometryOptions
) -> F64:
    """Return shifts (count, 3) in metres of points ``before`` (N, 3) to ``here`` (M, 3).

    They come from a phase correlation over the two widest axes, the most likely first.  Both are
    thinned to cells of ``cell`` metres and have the same rotation.
    """
    pixel = options.shift_pixel_cells * cell
    middle = np.median(before, axis=0)
    around = before - middle
    around = around[(np.abs(around) < options.shift_side_px * pixel).all(axis=1)]
    _, axes = np.linalg.eigh(np.einsum("ni,nj->ij", around, around))
    wide = axes[:, :0:-1]
    pictures = [
        _upright((xyz - middle) @ axes[:, ::-1], pixel, options=options) for xyz in (before, after)
    ]
    one, other = (np.fft.rfft2(picture) for picture in pictures)
    product = other * np.conj(one)
    product /= np.abs(product) ** options.shift_whitening + 1e-9
    middle_part = slice(
        options.shift_side_px // 2 - options.shift_max_px,
        options.shift_side_px // 2 + options.shift_max_px + 1,
    )
    likeness = np.fft.fftshift(
        np.fft.irfft2(product, s=(options.shift_side_px, options.shift_side_px))
    )[middle_part, middle_part]
    shifts = np.empty((count, 3))
    for number in range(count):
        row, column = (int(i) for i in np.unravel_index(likeness.argmax(), likeness.shape))
        shifts[number] = wide @ (
            np.array([row - options.shift_max_px, column - options.shift_max_px]) * pixel
        )
        rows = slice(max(0, row - options.shift_same_px), row + options.shift_same_px + 1)
        likeness[
            rows, max(0, column - options.shift_same_px) : column + options.shift_same_px + 1
        ] = -np.inf
    return shifts


def _upright(xyz: F64, pixel: float, options: ScanOdometryOptions) -> NDArray[np.float64]:
    """Return an image (WIDTH, WIDTH) of structures that extend along the last axis."""
    xyz = xyz[(np.abs(xyz[:, :2]) < (options.shift_side_px // 2 - 1) * pixel).all(axis=1)]
    at = np.floor(xyz[:, :2] / pixel).astype(np.int64) + options.shift_side_px // 2
    number, height = at[:, 0] * options.shift_side_px + at[:, 1], xyz[:, 2]
    high, low = (
        np.full(options.shift_side_px**2, -np.inf),
        np.full(options.shift_side_px**2, np.inf),
    )
    np.maximum.at(high, number, height)
    np.minimum.at(low, number, height)
    return (
        np.asarray(high > low + options.shift_steep_px * pixel)
        .astype(np.float64)
        .reshape(options.shift_side_px, options.shift_side_px)
    )


@dataclass(frozen=True, slots=True, eq=False)
class Planes:
    """Surface patches of a frame: ``at`` (M, 3), unit ``normal`` (M, 3), ``cell`` metres."""

    at: F64
    normal: F64
    tree: cKDTree
    cell: float


def planes_of(xyz: F64, options: TrackerOptions) -> Planes | None:
    """Return the patches of a frame (N, 3) thinned to cells; None: too few."""
    odometry, sensor = options.scan_odometry, options.range_image
    xyz = xyz[:: max(1, len(xyz) // odometry.plane_points)]
    if len(xyz) < odometry.min_points:
        return None
    far = reach_of(xyz, options=sensor) > sensor.camera_reach_m
    least = odometry.cell_min_m if far else 0.0
    cell = _cell(xyz, least, options=odometry)
    if cell <= 0.0:
        return None
    # Most points are on the ground near the sensor; thinning makes distant surfaces count by area.
    for _ in range(2):
        cell = _cell(nodes_of(xyz, cell), least, options=odometry)
    some = nodes_of(xyz, cell)
    if len(some) < odometry.min_planes * odometry.plane_neighbours:
        return None
    tree = cKDTree(some)
    sampled = some[:: max(1, len(some) // (odometry.candidates_per_plane * odometry.planes))]
    _, near = tree.query(sampled, k=odometry.plane_neighbours)
    around = some[near] - some[near].mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(around.transpose(0, 2, 1) @ around)
    flat = values[:, 0] < odometry.plane_flatness * values[:, 2]
    flat &= values[:, 1] > odometry.plane_breadth * values[:, 2]
    at, normal = sampled[flat], vectors[flat, :, 0]
    kept = _all_ways(normal, options=odometry)
    return Planes(at[kept], normal[kept], tree, cell)


def _cell(xyz: F64, least: float, options: ScanOdometryOptions) -> float:
    distance = np.linalg.norm(xyz - np.median(xyz, axis=0), axis=1)
    return max(options.cell_share * float(np.median(distance)), least)


def _all_ways(normal: F64, options: ScanOdometryOptions) -> I64:
    """Return sorted indices of planes with ``normal`` (M, 3), about as many for each axis.

    In a street nearly all planes are on the ground and walls, along which a frame could slip.
    Source: normal-space sampling, Rusinkiewicz and Levoy 2001.
    """
    axis = np.abs(normal).argmax(axis=1)
    ways = [np.flatnonzero(axis == a) for a in range(3)]
    return np.sort(
        np.concatenate([way[:: max(1, len(way) * 3 // (2 * options.planes))] for way in ways])
    )


def register(
    planes: Planes, target: cKDTree, start: F64, options: ScanOdometryOptions
) -> tuple[F64, float]:
    """Return the motion (4, 4) of ``planes`` to the points of ``target``, from ``start``.

    The second result is the share of the planes in place after it.
    """
    T = start
    for scale in options.scales_cells:
        reach = scale * planes.cell
        moved = transform(T, planes.at)
        normal = planes.normal @ T[:3, :3].T
        gap, index = target.query(moved, distance_upper_bound=max(reach, 2 * planes.cell))
        there = np.flatnonzero(np.isfinite(gap))
        if len(there) < options.plane_neighbours:
            return T, 0.0
        point, n = moved[there], normal[there]
        off = ((target.data[np.asarray(index)[there]] - point) * n).sum(axis=1)
        weight = 1.0 / (1.0 + (off / (0.5 * reach)) ** 2) ** 2
        middle = point.mean(axis=0)
        J = np.hstack([n, np.cross(point - middle, n)])
        H = J.T @ (J * weight[:, None])
        step = np.linalg.solve(H + 1e-6 * np.trace(H) * np.eye(6), J.T @ (weight * off))
        D = np.eye(4)
        D[:3, :3] = Rotation.from_rotvec(step[3:]).as_matrix()
        D[:3, 3] = step[:3] + middle - D[:3, :3] @ middle
        T = D @ T
    return T, in_place(planes, target, T, options=options)


def register_anywhere(
    planes: Planes,
    target: Planes,
    starts: Sequence[F64],
    options: ScanOdometryOptions,
    enough: float | None = None,
) -> tuple[F64, float]:
    """Return the best ``register`` from ``starts`` (4, 4).

    If the first start leaves a share of planes in place below ``enough``, the others and shifts of
    a phase correlation are tried as well.
    """
    if enough is None:
        enough = options.rest_share
    best = register(planes, target.tree, starts[0], options=options)
    if best[1] >= enough or not len(planes.at):
        return best
    moved = transform(starts[0], np.asarray(planes.tree.data))
    there = np.asarray(target.tree.data)
    shifts = likely_shifts(moved, there, planes.cell, options.shifts, options=options)
    middle = planes.at.mean(axis=0)[None]
    for start in [*starts[1:], *(_shifted(starts[0], shift) for shift in shifts)]:
        distance = np.linalg.norm(transform(start, middle) - transform(best[0], middle))
        if distance > options.shift_cells * planes.cell:
            best = max(best, register(planes, target.tree, start, options=options), key=_share)
    return best


def _shifted(T: F64, shift: F64) -> F64:
    moved = T.copy()
    moved[:3, 3] += shift
    return moved


def in_place(planes: Planes, target: cKDTree, T: F64, options: ScanOdometryOptions) -> float:
    """Return the share of the planes, moved by ``T``, with points of the target on them."""
    moved = transform(T, planes.at)
    gap, index = target.query(moved, distance_upper_bound=2 * planes.cell)
    there = np.flatnonzero(np.isfinite(gap))
    if not len(there):
        return 0.0
    normal = planes.normal[there] @ T[:3, :3].T
    off = ((target.data[np.asarray(index)[there]] - moved[there]) * normal).sum(axis=1)
    return float((np.abs(off) < options.on_plane_cells * planes.cell).sum() / len(moved))


def motions(frames: Frames, numbers: Sequence[int], options: TrackerOptions) -> Iterator[Motion]:
    """Yield the motion of the sensor from the first frame to each other one.

    The iteration ends at a frame with too few planes.
    """
    number, *others = numbers
    odometry = options.scan_odometry
    first = planes_of(np.asarray(frames(number).xyz, np.float64), options=options)
    if first is None:
        return
    for number in others:
        other = planes_of(np.asarray(frames(number).xyz, np.float64), options=options)
        if other is None:
            return
        before = in_place(first, other.tree, np.eye(4), options=odometry)
        if before > odometry.rest_share:
            yield "rests"
            continue
        T, share = register_anywhere(first, other, [np.eye(4)], options=odometry)
        shift = np.linalg.norm(transform(T, first.at) - first.at, axis=1)
        agreed = share > odometry.agreed_share
        better = 1.0 - share < odometry.left_share * (1.0 - before)
        if float(np.median(shift)) > odometry.moved_cells * first.cell:
            yield "moves" if agreed and better else "unclear"
        else:
            yield "rests" if agreed else "unclear"


def recorded_trajectory(
    frames: Frames, order: Sequence[int], options: TrackerOptions
) -> tuple[Trajectory | None, F64 | None]:
    """Return the recorded trajectory over ``order`` and the first frame's inverse pose (4, 4).

    The trajectory is None without recorded poses or for a sensor at rest; the pose is None if it is
    not recorded.
    """
    first, *others = (
        recorded_pose(frames(order[at]), options=options.scan_odometry)
        for at in (0, len(order) // 2, -1)
    )
    back = None if first is None else np.asarray(np.linalg.inv(first), np.float64)
    if back is not None and any(
        pose is not None and np.abs(back @ pose - np.eye(4)).max() > options.scan_odometry.rest_pose
        for pose in others
    ):
        return RecordedTrajectory(frames, back, options=options), back
    return None, back


def shown_at_rest(frames: Frames, numbers: Sequence[int], options: TrackerOptions) -> bool:
    """Return whether the sensor is at the same pose in all of some frames."""
    first = frames(numbers[0])
    lens = find_lens(first, moves=True, options=options)
    if lens is None:
        shown = motions(frames, numbers, options) if _of_one(first, options=options) else iter(())
    elif framed(first, lens, options=options):
        shown = camera_motions(frames, numbers, lens, options=options)
    else:
        return False
    rests = list(takewhile(lambda motion: motion == "rests", shown))
    return len(rests) == len(numbers) - 1


def find_trajectory(
    frames: Frames,
    order: Sequence[int],
    painted: I64 | None = None,
    *,
    at_rest: bool = False,
    options: TrackerOptions,
) -> Trajectory | None:
    """Return the trajectory of the sensor over ``order``, in coordinates of the first frame.

    It is recorded or estimated from the scene, without the ``painted`` points (M,) of the first
    frame.  None: the sensor is at rest, which may be known in advance.
    """
    recorded, back = recorded_trajectory(frames, order, options=options)
    if recorded is not None:
        return recorded
    first, last = frames(order[0]), len(order) - 1
    lens = find_lens(first, moves=True, options=options)
    if lens is not None:
        if at_rest or not framed(first, lens, options=options):
            return None
        positions = sorted({0, *options.scan_odometry.tested_frames, last // 2, last})
        numbers = [order[at] for at in positions if at <= last]
        moves = "moves" in camera_motions(frames, numbers, lens, painted, options=options)
        return CameraTrajectory(frames, order, options, lens, painted) if moves else None
    if not at_rest and _of_one(first, options=options):
        numbers = [order[at] for at in (0, *options.scan_odometry.tested_frames) if at <= last]
        if "moves" in motions(frames, numbers, options=options):
            return ScanTrajectory(frames, order, options)
    if not _goes_about(frames, order, options=options):
        return None
    return RecordedTrajectory(frames, np.eye(4) if back is None else back, options=options)


def _goes_about(frames: Frames, order: Sequence[int], options: TrackerOptions) -> bool:
    """Return whether a lidar has moving recorded viewpoints, so that frames are in the world."""
    first, *others = (frames(order[at]) for at in (0, len(order) // 2, -1))
    if (
        first.viewpoint is None
        or reach_of(np.asarray(first.xyz), options=options.range_image)
        <= options.range_image.camera_reach_m
    ):
        return False
    ways = [eye - first.viewpoint for f in others if (eye := f.viewpoint) is not None]
    return any(float(np.abs(way).max()) > options.scan_odometry.rest_pose for way in ways)


def _of_one(frame: TrackFrame, options: TrackerOptions) -> bool:
    """Return whether a single sensor saw a frame.

    Frames of several sensors, and figures without their room, have no static scene that shows the
    motion of a sensor.
    """
    xyz = np.asarray(frame.xyz)
    return frame.sensor is None and (
        frame.viewpoint is not None
        or reach_of(xyz, options=options.range_image) > options.range_image.camera_reach_m
        or find_eye(xyz, options=options) is not None
    )


def _share(fit: tuple[F64, float]) -> float:
    return fit[1]


class ScanTrajectory(RegisteredTrajectory):
    """A sensor's trajectory estimated from planes of the scene."""

    def __init__(self, frames: Frames, order: Sequence[int], options: TrackerOptions) -> None:
        super().__init__(frames, order, options)
        self._enough = self.options.scan_odometry.rest_share
        self._last = planes_of(np.asarray(frames(order[0]).xyz, np.float64), options=options)

    def _registered(self, frame: TrackFrame) -> F64:
        options = self.options.scan_odometry
        planes = planes_of(np.asarray(frame.xyz, np.float64), options=self.options)
        before = self._poses[-1]
        step = np.linalg.inv(self._poses[-2]) @ before if len(self._poses) > 1 else np.eye(4)
        if self._last is None or planes is None:
            return np.asarray(before @ step)
        starts = [np.asarray(np.linalg.inv(step)), np.eye(4)]
        T, share = register_anywhere(self._last, planes, starts, options, self._enough)
        self._enough = min(options.rest_share, share - options.restart_drop)
        self._last = planes
        return np.asarray(before @ np.linalg.inv(T))
