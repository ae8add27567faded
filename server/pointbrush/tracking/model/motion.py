"""Motion of an object: predictions of its next pose from the last poses."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import F64
from pointbrush.tracking.options.steps import SearchOptions


@dataclass(frozen=True, eq=False)
class Motion:
    """Last poses ``T_frame_start``, and the object's ``centre`` (3,) in the start frame."""

    options: SearchOptions
    centre: F64
    poses: tuple[F64, ...] = field(default_factory=lambda: (np.eye(4),))
    gap: int = 1
    """Frames since the last pose."""
    rested: F64 | None = None
    """Resting pose of its last clear observation, unless it was seen elsewhere since; it guards
    against apparent motion caused by an occluding object."""

    def add(self, pose: F64, sure: bool = True) -> Motion:
        """Return the motion with a found pose; a gap is filled by constant motion.

        An uncertain pose moves the object and keeps its velocity.
        """
        if not sure and len(self.poses) > 1:
            spin = self.poses[-1][:3, :3] @ self.poses[-2][:3, :3].T
            velocity = self._at(-1) - self._at(-2)
            now = transform(pose, self.centre[None])[0]
            before = _orthogonal(spin.T @ pose[:3, :3])
            return replace(self, poses=(self._pose(before, now - velocity), pose), gap=1)
        poses = self.poses
        if self.gap > 1:
            poses = (_between(poses[-1], pose, self.centre, 1 - 1 / self.gap),)
        kept = (*poses, pose)[-self.options.remembered_poses :]
        return replace(self, poses=kept, gap=1)

    def begin(self, pose: F64) -> Motion:
        """Return a motion restarted at a pose, with an unknown velocity."""
        return replace(self, poses=(pose,), gap=1, rested=None)

    def go_along(self, step: F64) -> Motion:
        """Return the motion of an occluded object moved by its carrier's ``step`` (3,)."""
        along = np.eye(4)
        along[:3, 3] = step
        return replace(self, poses=tuple(along @ pose for pose in self.poses), gap=1)

    def seen(self, unit: float) -> Motion:
        """Return the motion after a clear observation at the last pose."""
        return replace(self, rested=self.poses[-1] if self.rests(unit) else None)

    def unseen(self) -> Motion:
        """Return the motion after a frame without a detection."""
        return replace(self, gap=self.gap + 1)

    @property
    def resting_pose(self) -> F64:
        """The pose (4, 4) of an object at rest: its resting pose or its last one."""
        return self.poses[-1] if self.rested is None else self.rested

    @property
    def is_unknown(self) -> bool:
        """Whether it is still unknown, for want of frames."""
        return len(self.poses) < 3

    @cached_property
    def speed(self) -> float:
        """Speed of the centre, in metres per frame."""
        if len(self.poses) < 2:
            return 0.0
        return float(np.linalg.norm(self._at(-1) - self._at(-2)))

    @property
    def place(self) -> F64:
        """Last position (3,) of the centre."""
        return self._at(-1)

    @property
    def extrapolated_place(self) -> F64:
        """(3,) predicted position of the centre if its last step is repeated."""
        place = self._at(-1)
        return place if len(self.poses) < 2 else place + self.gap * (place - self._at(-2))

    def slow(self, unit: float) -> bool:
        """Return whether it is nearly at rest, so that it may not take another object's place."""
        return len(self.poses) > 1 and self.speed < unit

    def rests(self, unit: float) -> bool:
        """Return whether it has been at rest in all stored frames."""
        return len(self.poses) >= self.options.remembered_poses and self._farthest < 2 * unit

    @cached_property
    def _farthest(self) -> float:
        """Return the distance (m) of the centre to its farthest stored position."""
        path = np.vstack([transform(T, self.centre[None]) for T in self.poses])
        return float(np.linalg.norm(path - path[-1], axis=1).max())

    def _at(self, which: int) -> F64:
        pose = self.poses[which]
        return np.asarray(pose[:3, :3] @ self.centre + pose[:3, 3])

    @cached_property
    def predictions(self) -> F64:
        """(K, 4, 4) candidates, most likely first: constant and changing motion, and at rest."""
        last, place = self.poses[-1], self._at(-1)
        if len(self.poses) < 2:
            return last[None]
        spin = last[:3, :3] @ self.poses[-2][:3, :3].T
        velocity = place - self._at(-2)
        turned, step = last[:3, :3], np.zeros(3)
        gain = np.zeros(3)
        if len(self.poses) > 2:
            gain = velocity - (self._at(-2) - self._at(-3))
        falling = velocity
        even = np.zeros(3)
        for _ in range(self.gap):
            turned = spin @ turned
            step = step + velocity
            falling = falling + gain
            even = even + falling
        turned, kept = _orthogonal(np.stack([turned, last[:3, :3]]))
        result = [self._pose(turned, place + step)]
        result += [self._pose(kept, place + step), self._pose(kept, place)]
        if len(self.poses) > 2:
            result = [self._swung(turned), self._pose(turned, place + even), *result]
        if self.rested is not None:
            result.append(self.rested)
        return np.stack(result)

    def _swung(self, turned: F64) -> F64:
        """Return the prediction by a rotation about the point with the most uniform motion.

        In the air this point is the centre of mass; in a hand it is near the grip.  It is found by
        least squares over second differences of the last poses, regularised to the centre.
        """
        poses = np.stack(self.poses)
        bend = poses[:-2] - 2 * poses[1:-1] + poses[2:]
        A, b = bend[:, :3, :3], -(bend[:, :3, :3] @ self.centre + bend[:, :3, 3])
        leaning = self.options.pivot_ridge**2 * np.eye(3) + (A.transpose(0, 2, 1) @ A).sum(axis=0)
        pivot = self.centre + np.linalg.solve(leaning, np.einsum("kij,ki->j", A, b))
        path = poses[:, :3, :3] @ pivot + poses[:, :3, 3]
        velocity, gain = path[-1] - path[-2], (bend[:, :3, :3] @ pivot + bend[:, :3, 3]).mean(0)
        T = np.eye(4)
        T[:3, :3] = turned
        ahead = path[-1] + self.gap * velocity + self.gap * (self.gap + 1) / 2 * gain
        T[:3, 3] = ahead - turned @ pivot
        return T

    def _pose(self, R: F64, at: F64) -> F64:
        T = np.eye(4)
        T[:3, :3] = R
        T[:3, 3] = at - T[:3, :3] @ self.centre
        return T


def _orthogonal(R: F64) -> F64:
    """Return the rotations nearest to matrices (..., 3, 3)."""
    U, _, Vt = np.linalg.svd(R)
    return np.asarray(U @ Vt)


def _between(a: F64, b: F64, centre: F64, share: float) -> F64:
    """Return a pose between ``a`` and ``b``, with the rotation of ``b``."""
    start, end = transform(a, centre[None])[0], transform(b, centre[None])[0]
    T = b.copy()
    T[:3, 3] = start + share * (end - start) - b[:3, :3] @ centre
    return T
