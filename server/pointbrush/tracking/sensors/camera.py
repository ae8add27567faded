"""Camera model of a depth camera: pinhole image, detected pixel lattice, swaying camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.tracking.interface import F32, F64, I64, PixelLattice, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.sensors import LensOptions
from pointbrush.tracking.sensors.scanner import reach_of

I32 = NDArray[np.int32]


class Projection(NamedTuple):
    """Projection of points (N,) into a depth image.

    ``cell``: row * width + column, -1 outside; ``depth``: metres along the image's axis.
    """

    cell: I32
    depth: F32

    def pick(self, indices: I64) -> Projection:
        """Return the projection of some of the points (M,)."""
        return Projection(self.cell[indices], self.depth[indices])


@dataclass(frozen=True, eq=False)
class Lens:
    """A pixel grid of directions from ``eye`` (3,), looking along ``sign`` × ``axis``.

    ``turn`` (3, 3): rotation from the frame's axes to the image's, None if they are equal;
    ``lattice``: whether its pixels are the sensor's own, with one point each.  The image is a part
    of a depth image with rows of ``stride`` cells, from cell ``start``; by default it is all of it.
    """

    eye: F32
    turn: F32 | None
    axis: int
    sign: float
    least: tuple[float, float]
    pitch: tuple[float, float]
    shape: tuple[int, int]
    lattice: bool = True
    start: int = 0
    stride: int | None = None

    def cells(self, xyz: F32, options: LensOptions) -> Projection:
        """Project points (N, 3) into the image."""
        return Projection(*_cells(self.pixels, np.asarray(xyz, np.float32), options.nearest_m))

    @cached_property
    def T_picture_frame(self) -> F64:  # noqa: N802  (named for its direction)
        """(4, 4) to coordinates across, down and along the image, with the eye as origin."""
        across, down = (a for a in range(3) if a != self.axis)
        turn = np.zeros((3, 3))
        turn[0, across] = turn[1, down] = 1.0
        turn[2, self.axis] = self.sign
        if self.turn is not None:
            turn = turn @ self.turn
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = turn, -turn @ self.eye
        return T

    @cached_property
    def pixels(self) -> Pixels:
        """The lens for compiled loops."""
        across, down = (a for a in range(3) if a != self.axis)
        turn = np.eye(3, dtype=np.float32) if self.turn is None else self.turn
        x, y, z = self.eye.tolist()
        axes = across, down, self.axis
        stride = self.stride or self.shape[1]
        return Pixels(
            (x, y, z),
            turn,
            axes,
            self.sign,
            self.least,
            self.pitch,
            *self.shape,
            self.start,
            stride,
        )


class Pixels(NamedTuple):
    """A ``Lens`` as numbers and arrays: ``axes`` across, down and along in the image."""

    eye: tuple[float, float, float]
    turn: F32
    axes: tuple[int, int, int]
    sign: float
    least: tuple[float, float]
    pitch: tuple[float, float]
    height: int
    width: int
    start: int
    stride: int


@innermost
def pixel(lens: Pixels, at: tuple[float, float, float], nearest_m: float) -> tuple[int, float]:
    """Return the flat cell, -1 outside, and the depth of a point in the frame's coordinates."""
    x, y, z = at[0] - lens.eye[0], at[1] - lens.eye[1], at[2] - lens.eye[2]
    turn = lens.turn
    local = (
        turn[0, 0] * x + turn[0, 1] * y + turn[0, 2] * z,
        turn[1, 0] * x + turn[1, 1] * y + turn[1, 2] * z,
        turn[2, 0] * x + turn[2, 1] * y + turn[2, 2] * z,
    )
    depth = lens.sign * local[lens.axes[2]]
    if not depth > nearest_m:
        return -1, depth
    u = (local[lens.axes[0]] / depth - lens.least[0]) / lens.pitch[0] + 0.5
    v = (local[lens.axes[1]] / depth - lens.least[1]) / lens.pitch[1] + 0.5
    if u >= 0 and u < lens.width and v >= 0 and v < lens.height:
        return lens.start + int(v) * lens.stride + int(u), depth
    return -1, depth


@compiled
def _cells(lens: Pixels, xyz: F32, nearest_m: float) -> tuple[I32, F32]:
    cell, depth = np.empty(len(xyz), np.int32), np.empty(len(xyz), np.float32)
    for i in range(len(xyz)):
        cell[i], depth[i] = pixel(lens, (xyz[i, 0], xyz[i, 1], xyz[i, 2]), nearest_m)
    return cell, depth


def find_lens(
    frame: TrackFrame, *, moves: bool = False, place: F64 | None = None, options: TrackerOptions
) -> Lens | None:
    """Return the pixel grid of a pinhole-like frame; None if it has none, or several sensors.

    The grid comes from the import or is estimated from the points.  ``place`` (3,): assumed
    position of a sensor without a recorded one, by default the origin.  For a sensor that ``moves``
    a grid requires a visible lattice or a depth camera's range: a lidar's front view is tracked
    better as a range image.
    """
    xyz = np.asarray(frame.xyz)
    if len(xyz) < options.lens.min_points or frame.sensor is not None:
        return None
    if frame.lattice is not None:
        return imported_lens(frame.lattice, options=options.lens)
    is_recorded = frame.viewpoint is not None
    supposed = np.zeros(3) if place is None else place
    eye = np.asarray(frame.viewpoint if is_recorded else supposed, np.float64)
    sample = xyz[:: max(1, len(xyz) // options.lens.sampled_points)].astype(np.float64) - eye
    facing = _in_image_axes(sample, options=options.lens)
    if facing is None:
        return None
    sample, along, turn = facing
    plane = _tangents(sample, *along)
    spacing = float(np.sqrt(np.ptp(plane[0]) * np.ptp(plane[1]) / len(xyz)))
    pitch = [
        p
        for p in (_lattice(tangents, options.lens) for tangents in plane)
        if p is not None and p > options.lens.min_pitch_spacings * spacing
    ]
    if turn is None and len(pitch) == 2:
        return _lens(sample, eye, None, along, (pitch[0], pitch[1]), options=options.lens)
    if spacing <= 0 or (
        moves and reach_of(xyz, options=options.range_image) > options.range_image.camera_reach_m
    ):
        return None
    size = options.lens.pixel_spacings * spacing
    lens = _lens(sample, eye, turn, along, (size, size), options=options.lens)
    sought = options.lens.filled_share if place is None else options.lens.filled_share_sought
    least = 0.0 if is_recorded else sought
    if lens is None or not _is_image(lens, xyz, is_recorded, least, options=options.lens):
        return None
    return replace(lens, lattice=False)


def _in_image_axes(
    local: F64, options: LensOptions
) -> tuple[F64, tuple[int, float], F64 | None] | None:
    """Return points (N, 3) in image axes, the image's axis, and the rotation (3, 3) to it.

    Points around none of the frame's axes are rotated to their mean ray.  None: see ``_axis``.
    """
    along = _axis(local, options=options)
    if along is not None:
        return local, along, None
    turn = _facing(local)
    turned = local @ turn.T
    along = _axis(turned, options=options)
    return None if along is None else (turned, along, turn)


def imported_lens(lattice: PixelLattice, options: LensOptions) -> Lens:
    """Return the pixel grid found by the import, with a margin around the image."""
    margin = options.margin_px
    least, up = (
        start - margin * pitch for start, pitch in zip(lattice.tangent, lattice.pitch, strict=True)
    )
    shape = lattice.height + 2 * margin, lattice.width + 2 * margin
    eye = np.array(lattice.eye, np.float32)
    return Lens(eye, None, lattice.axis, lattice.sign, (least, up), lattice.pitch, shape)


def _lens(
    local: F64,
    eye: F64,
    turn: F64 | None,
    along: tuple[int, float],
    pitch: tuple[float, float],
    options: LensOptions,
) -> Lens | None:
    plane = _tangents(local, *along)
    low = [float(t.min()) - options.margin_px * p for t, p in zip(plane, pitch, strict=True)]
    width, height = (
        int(np.ptp(t) / p) + 2 * options.margin_px + 1 for t, p in zip(plane, pitch, strict=True)
    )
    if width * height > options.max_pixels:
        return None
    turned = None if turn is None else turn.astype(np.float32)
    at = eye.astype(np.float32)
    return Lens(at, turned, *along, (low[0], low[1]), pitch, (height, width))


def _tangents(local: F64, axis: int, sign: float) -> list[F64]:
    depth = sign * local[:, axis]
    return [local[:, a] / depth for a in range(3) if a != axis]


def _axis(local: F64, options: LensOptions) -> tuple[int, float] | None:
    """Return the axis and sign of the direction to points (N, 3); None: they spread too far."""
    for axis in np.argsort(-np.abs(local.mean(axis=0))).tolist():
        sign = 1.0 if local[:, axis].mean() > 0 else -1.0
        depth = sign * local[:, axis]
        others = np.abs(np.delete(local, axis, axis=1)).max(axis=1)
        if depth.min() > 0 and (others / depth).max() < options.half_view_tan:
            return axis, sign
    return None


def _facing(local: F64) -> F64:
    """Return ``axes_along`` the mean ray of the points (N, 3)."""
    rays = local / np.maximum(np.linalg.norm(local, axis=1, keepdims=True), 1e-9)
    forward = rays.mean(axis=0)
    forward /= max(float(np.linalg.norm(forward)), 1e-9)
    return axes_along(forward)


def axes_along(forward: F64) -> F64:
    """Return (3, 3) rows right, down and ahead of an image that looks along a unit vector (3,)."""
    right = np.cross(np.eye(3)[np.argmin(np.abs(forward))], forward)
    right /= max(float(np.linalg.norm(right)), 1e-9)
    return np.stack([right, np.cross(forward, right), forward])


def _is_image(lens: Lens, xyz: F32, is_recorded: bool, least: float, options: LensOptions) -> bool:
    """Return whether points (N, 3) are an image of a sensor at the position of ``lens``.

    Each direction has one surface, continuous with its neighbours, and at least a share ``least``
    of the image is filled.  Tolerances are larger if the position ``is_recorded``.
    """
    cell, depth = lens.cells(np.asarray(xyz, np.float32), options=options)
    nearest = np.full(lens.shape[0] * lens.shape[1] + 1, np.inf, np.float32)
    np.minimum.at(nearest, cell, depth)
    behind = float((depth / np.float32(options.behind_ratio) > nearest[cell]).mean())
    height, width = (size - 2 * options.margin_px for size in lens.shape)
    filled = np.isfinite(nearest).sum() > least * height * width
    if _discontinuous_share(nearest[:-1].reshape(lens.shape), options=options) > options.torn_share:
        return False
    return bool(filled) and behind < (
        options.behind_share_recorded if is_recorded else options.behind_share
    )


def _discontinuous_share(image: F32, options: LensOptions) -> float:
    """Return the share of adjacent pixels, inf if empty, that are not on a common surface."""
    pairs, torn = 0, 0
    for one, other in ((image[1:], image[:-1]), (image[:, 1:], image[:, :-1])):
        near, far = np.minimum(one, other), np.maximum(one, other)
        known = np.isfinite(far)
        pairs += int(np.count_nonzero(known))
        torn += int(np.count_nonzero(far[known] > (1.0 + options.torn_depth) * near[known]))
    return torn / max(pairs, 1)


def _lattice(tangent: F64, options: LensOptions) -> float | None:
    """Return the pitch of the lattice of tangents (N,) along one side of an image; None: none."""
    values = np.sort(tangent)
    levels = values[np.diff(values, prepend=-np.inf) > options.lattice_tolerance]
    if len(levels) < options.min_lattice_lines or options.min_points_per_line * len(levels) > len(
        values
    ):
        return None
    roughly = float(np.median(np.diff(levels)))
    width = float(np.ptp(levels))
    return width / round(width / roughly)


def steadied(lens: Lens, depth: F32, poses: Sequence[F64], options: TrackerOptions) -> Lens | None:
    """Return the pixel grid, in the world, of a camera at rest that covers a swaying sensor's view.

    ``poses`` (4, 4): ``T_world_frame`` of frames across a run, each with the sensor's ``lens``;
    ``depth`` (M,): measured depths.  None: it moves or turns too far.
    """
    way = np.array([pose[:3, :3] @ lens.eye + pose[:3, 3] for pose in poses])
    eye = 0.5 * (way.min(axis=0) + way.max(axis=0))
    near, far = np.percentile(
        depth, [options.sway.near_percentile, 100 - options.sway.near_percentile]
    )
    if (
        np.linalg.norm(way - eye, axis=1).max() * (1.0 / near - 1.0 / far)
        > options.sway.max_parallax
    ):
        return None
    to = lens.T_picture_frame[:3, :3]
    low, pitch = np.array(lens.least), np.array(lens.pitch)
    size = pitch * lens.shape[::-1]
    corners = low + size * [[0, 0], [0, 1], [1, 0], [1, 1]]
    rays = np.hstack([corners, np.ones((4, 1))])
    turned = np.concatenate([rays @ (to @ pose[:3, :3] @ to.T).T for pose in poses])
    if turned[:, 2].min() <= 0.0:
        return None
    plane = turned[:, :2] / turned[:, 2:]
    least, most = plane.min(axis=0), plane.max(axis=0)
    if (most - least > options.sway.max_extent * size).any():
        return None
    least, most = least - options.sway.margin_share * size, most + options.sway.margin_share * size
    pitch = pitch * (options.lens.pixel_spacings if lens.lattice else 1.0)
    across, down = np.ceil((most - least) / pitch).astype(int).tolist()
    return replace(
        lens,
        eye=eye.astype(np.float32),
        least=(float(least[0]), float(least[1])),
        pitch=(float(pitch[0]), float(pitch[1])),
        shape=(down, across),
        lattice=False,
    )
