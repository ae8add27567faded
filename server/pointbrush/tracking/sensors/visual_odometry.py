"""Dense visual odometry of a depth camera: all pixels at once, coarse to fine.

The motion minimises differences of colours and of depths between two pictures; moving objects and
outlines are outliers.  Source: dense visual odometry, Steinbruecker, Sturm and Cremers 2011, Kerl,
Sturm and Cremers 2013, with the robust weight of Geman and McClure 1985.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F32, F64, I64, Frames, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.sensors import LensOptions, VisualOdometryOptions
from pointbrush.tracking.sensors.camera import Lens
from pointbrush.tracking.sensors.image_pyramid import Image, Layer, compared, equations, picture_of
from pointbrush.tracking.sensors.trajectory import Motion, RegisteredTrajectory, Trajectory

SPREAD = 1.4826
"""Ratio of standard deviation to median deviation of normally distributed values."""


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Motion between two pictures.

    ``T`` (4, 4): motion to the other picture, in the frames' coordinates; ``agree`` and ``before``:
    agreement of the pictures, 0 to 1, with and without the motion; ``shift``: median motion of the
    scene in pixels of the finest picture; ``off`` (M, channels): residuals; ``scale`` (channels,):
    standard deviation of inliers.
    """

    T: F64
    agree: float
    before: float
    shift: float
    off: F32
    scale: F64


def motion_between(
    one: Sequence[Layer],
    other: Sequence[Layer],
    lens: Lens,
    starts: Sequence[F64],
    options: TrackerOptions,
) -> Fit:
    """Return the motion of the scene from the picture ``one`` to the ``other``.

    ``starts`` (4, 4): initial motions, in the frames' coordinates.  If the result is far from all
    of them, rotations of the first are tried as well.
    """
    to = lens.T_picture_frame
    back = np.linalg.inv(to)
    initial = [_rigid(to @ start @ back) for start in starts]
    T = _followed(one, other, initial, options=options)
    if min(_shift(one[0], T, start) for start in initial) > options.visual_odometry.near_px:
        T = _followed(one, other, [T, *_turned_starts(one[0], other[0], initial, options)], options)
    odometry, still = options.visual_odometry, np.eye(4)
    off, left = (_off(one[-1], other[-1].image, D, options=options.lens) for D in (T, still))
    scale = _scale(off, options=odometry)
    agree, before = (_agreement(each, scale, options=odometry) for each in (off, left))
    return Fit(back @ T @ to, agree, before, _shift(one[-1], T, still), off, scale)


def _turned_starts(
    layer: Layer, target: Layer, initial: Sequence[F64], options: TrackerOptions
) -> list[F64]:
    """Return the best of the ``initial`` motions and rotations of the first, slightly refined."""
    motion = options.visual_odometry
    tried = [
        _refined(layer, target.image, start, motion.tried_iterations, options=options)
        for start in [
            *initial,
            *(turn @ initial[0] for turn in _turns(layer.image, options=motion)),
        ]
    ]
    return _sort_by_agreement(layer, target.image, tried, options=options)[: motion.starts_followed]


def _rigid(T: F64) -> F64:
    """Return the rigid motion nearest to a product of motions, to avoid rounding drift."""
    result = T.copy()
    result[:3, :3] = Rotation.from_matrix(T[:3, :3]).as_matrix()
    return result


def _followed(
    one: Sequence[Layer], other: Sequence[Layer], found: list[F64], options: TrackerOptions
) -> F64:
    """Return the best of some motions, refined from coarse to fine levels."""
    for layer, target in zip(one, other, strict=True):
        found = [
            _refined(layer, target.image, T, options.visual_odometry.iterations, options=options)
            for T in found
        ]
        if layer is not one[0]:
            found = _sort_by_agreement(layer, target.image, found, options=options)[:1]
    return _sort_by_agreement(one[-1], other[-1].image, found, options=options)[0]


def _turns(image: Image, options: VisualOdometryOptions) -> list[F64]:
    """Return rotations of a camera sideways and upward by some pixels."""
    x, y = image.pitch
    turns = []
    for aside, upward in product(options.start_aside_px, options.start_upward_px):
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec([upward * y, aside * x, 0.0]).as_matrix()
        turns.append(turn)
    return turns


def _sort_by_agreement(
    layer: Layer, image: Image, found: list[F64], options: TrackerOptions
) -> list[F64]:
    """Return the motions in descending order of agreement of the pictures."""
    off = [_off(layer, image, T, options=options.lens) for T in found]
    scale = np.min([_scale(each, options=options.visual_odometry) for each in off], axis=0)
    order = np.argsort(
        [-_agreement(each, scale, options=options.visual_odometry) for each in off], kind="stable"
    )
    return [found[i] for i in order.tolist()]


def _off(layer: Layer, image: Image, T: F64, options: LensOptions) -> F32:
    return compared(T, layer.points, layer.values, image, options.nearest_m)


def _scale(off: F32, options: VisualOdometryOptions) -> F64:
    """Return (channels,) the robust standard deviation; inf if too few pixels are compared."""
    there = off[np.isfinite(off[:, -1])]
    if len(there) < options.min_pixels:
        return np.full(off.shape[1], np.inf)
    return np.asarray(SPREAD * np.median(np.abs(there), axis=0) + 1e-6, np.float64)


def _agreement(off: F32, scale: F64, options: VisualOdometryOptions) -> float:
    if not len(off):
        return 0.0
    far = ((off / (options.robust_sigmas * scale)) ** 2).mean(axis=1)
    return float((1.0 / (1.0 + np.nan_to_num(far, nan=np.inf))).mean())


def _shift(layer: Layer, T: F64, start: F64) -> float:
    """Return the median difference, in pixels, of the scene's positions by two motions."""
    ends = [transform(motion, layer.points) for motion in (T, start)]
    ahead = (ends[0][:, 2] > 0) & (ends[1][:, 2] > 0)
    if not ahead.any():
        return np.inf
    one, other = (end[ahead, :2] / end[ahead, 2:] for end in ends)
    return float(np.median(np.linalg.norm((one - other) / np.array(layer.image.pitch), axis=1)))


def _refined(layer: Layer, image: Image, T: F64, steps: int, options: TrackerOptions) -> F64:
    """Return a motion refined by Gauss-Newton steps."""
    odometry, nearest_m = options.visual_odometry, options.lens.nearest_m
    depth = float(np.median(layer.points[:, 2])) if len(layer.points) else 1.0
    for _ in range(steps):
        off = _off(layer, image, T, options=options.lens)
        scale = _scale(off, options=odometry)
        if np.isinf(scale).any():
            break
        reach = odometry.robust_sigmas * scale
        H, g = equations(T, layer.points, off, image, reach, nearest_m)
        step = np.linalg.solve(H + 1e-6 * np.trace(H) * np.eye(6), g)
        D = np.eye(4)
        D[:3, :3] = Rotation.from_rotvec(step[3:]).as_matrix()
        D[:3, 3] = step[:3]
        T = D @ T
        moved = np.linalg.norm(step[:3]) / depth + np.linalg.norm(step[3:])
        if moved < odometry.settled_px * image.pitch[0]:
            break
    return T


def camera_motions(
    frames: Frames,
    numbers: Sequence[int],
    lens: Lens,
    painted: I64 | None = None,
    *,
    options: TrackerOptions,
) -> Iterator[Motion]:
    """Yield the motion of the sensor from the first of some frames to each other one.

    Points ``painted`` (M,) in the first, usually people, may move independently and are excluded.
    A frame with too little of the scene, such as behind a person stopping the recording, is
    unclear.
    """
    first, *others = numbers
    odometry = options.visual_odometry
    picture = picture_of(frames(first), lens, painted, options=options)
    scale = None
    for number in others:
        other = picture_of(frames(number), lens, options=options)
        fit = motion_between(picture, other, lens, [np.eye(4)], options=options)
        scale = fit.scale if scale is None else scale
        is_shifted = fit.shift > odometry.moved_px
        better = 1.0 - fit.agree < odometry.left_share * (1.0 - fit.before)
        agreed = _agreement(fit.off, scale, options=odometry) >= odometry.lost_agreement
        if not agreed or (is_shifted and not better):
            yield "unclear"
        else:
            yield "moves" if is_shifted else "rests"


def framed(frame: TrackFrame, lens: Lens, options: TrackerOptions) -> bool:
    """Return whether the scene extends to the borders of its picture.

    A figure cut out of its scene has only moving points, which do not show a camera's motion.
    """
    height, width = lens.shape
    seen = np.zeros(height * width + 1, np.bool_)
    seen[lens.cells(np.asarray(frame.xyz, np.float32), options=options.lens).cell] = True
    image = seen[:-1].reshape(height, width)
    if not image.any():
        return False
    # A pixel grid found by the import has a wider margin than a grid detected here.
    rows, columns = (np.flatnonzero(image.any(axis=axis)) for axis in (1, 0))
    image = image[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    band = max(1, int(options.visual_odometry.band_share * min(image.shape)))
    sides = (image[:band], image[-band:], image[:, :band], image[:, -band:])
    return float(np.mean([side.mean() for side in sides])) > options.visual_odometry.border_share


class CameraTrajectory(RegisteredTrajectory):
    """A depth camera's trajectory by visual odometry.

    A frame is registered to the last one, and then to the oldest keyframe with most of its scene,
    to avoid drift.  A frame without agreement, such as with a hand in front of the lens, is
    relocalised at older keyframes.
    """

    def __init__(
        self,
        frames: Frames,
        order: Sequence[int],
        options: TrackerOptions,
        lens: Lens,
        painted: I64 | None = None,
    ) -> None:
        """``painted`` (M,): points of the first frame that may move, excluded from registration."""
        super().__init__(frames, order, options)
        self._lens, self._painted = lens, painted
        first = _Key(picture_of(frames(order[0]), lens, painted, options=options), np.eye(4))
        self._last, self._keys = first, [first]
        self._scale: F64 | None = None

    def over(self, some: Sequence[int]) -> Trajectory:
        """See ``Trajectory``."""
        return CameraTrajectory(self._frames, some, self.options, self._lens, self._painted)

    def _registered(self, frame: TrackFrame) -> F64:
        picture = picture_of(frame, self._lens, options=self.options)
        last = self._poses[-1]
        step = inverse(self._poses[-2]) @ last if len(self._poses) > 1 else np.eye(4)
        fit = self._onto(picture, self._last, [last @ step, last])
        if self._scale is None and np.isfinite(fit.scale).all():
            self._scale = fit.scale
        pose, lost = self._last.pose @ inverse(fit.T), self._lost(fit)
        most = self.options.visual_odometry.keyframe_shift * max(picture[-1].image.values.shape)
        for key in self._keys:
            if key is self._last or not (lost or self._apart(key, pose) <= most):
                continue
            fit = self._onto(picture, key, [key.pose] if lost else [pose, key.pose])
            if fit.shift <= most and not self._lost(fit):
                pose, lost = key.pose @ inverse(fit.T), False
                break
        else:
            if not lost and self._last is not self._keys[-1]:
                self._keys.append(self._last)
        if lost:
            self.lost.add(self._order[len(self._poses)])
            return last
        self._last = _Key(picture, np.asarray(pose))
        return self._last.pose

    def _onto(self, picture: list[Layer], key: _Key, hypotheses: list[F64]) -> Fit:
        starts = [inverse(hypothesis) @ key.pose for hypothesis in hypotheses]
        return motion_between(key.picture, picture, self._lens, starts, options=self.options)

    def _lost(self, fit: Fit) -> bool:
        """Return whether too few pixels agree."""
        options = self.options.visual_odometry
        return (
            self._scale is None
            or _agreement(fit.off, self._scale, options=options) < options.lost_agreement
        )

    def _apart(self, key: _Key, pose: F64) -> float:
        """Return the shift, in pixels of the finest picture, from a key's view to ``pose``."""
        to = self._lens.T_picture_frame
        return _shift(key.picture[-1], to @ inverse(pose) @ key.pose @ np.linalg.inv(to), np.eye(4))


class _Key(NamedTuple):
    """A keyframe: its picture and ``T_world_frame``."""

    picture: list[Layer]
    pose: F64
