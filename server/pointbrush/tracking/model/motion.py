"""Motion of an object: predicted poses from its last ones, with variations worth trying."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import F64
from pointbrush.tracking.options.steps import SearchOptions


@dataclass(frozen=True, eq=False)
class Motion:
    """Poses ``T_frame_start`` of the last frames; ``centre`` (3,) of the object in the start."""

    options: SearchOptions
    centre: F64
    poses: tuple[F64, ...] = field(default_factory=lambda: (np.eye(4),))
    gap: int = 1
    """Frames since the last pose."""
    rested: F64 | None = None
    """The pose at which it rested when it was last well seen, unless it was seen elsewhere since:
    what hides it may seem to push it, or to have taken it along."""

    def add(self, pose: F64, sure: bool = True) -> Motion:
        """The object was found; a gap is filled by even motion.

        An unsure pose moves the object, and leaves its motion as it was.
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
        """The object was found where no motion led: what it was doing is unknown."""
        return replace(self, poses=(pose,), gap=1, rested=None)

    def go_along(self, step: F64) -> Motion:
        """It was hidden, and is a ``step`` (3,) farther on with who carries it."""
        along = np.eye(4)
        along[:3, 3] = step
        return replace(self, poses=tuple(along @ pose for pose in self.poses), gap=1)

    def seen(self, unit: float) -> Motion:
        """It was well seen at its last pose."""
        return replace(self, rested=self.poses[-1] if self.rests(unit) else None)

    def unseen(self) -> Motion:
        """It was not found in a frame."""
        return replace(self, gap=self.gap + 1)

    @property
    def resting_pose(self) -> F64:
        """The pose (4, 4) if it has not moved: where it rested, or where it was last."""
        return self.poses[-1] if self.rested is None else self.rested

    @property
    def fresh(self) -> bool:
        """Whether its motion is not known yet."""
        return len(self.poses) < 3

    @cached_property
    def speed(self) -> float:
        """Metres a frame, of the centre."""
        if len(self.poses) < 2:
            return 0.0
        return float(np.linalg.norm(self._at(-1) - self._at(-2)))

    @property
    def place(self) -> F64:
        """Last place (3,) of the centre."""
        return self._at(-1)

    @property
    def even(self) -> F64:
        """(3,) where the centre is in the next frame if its last step is repeated."""
        here = self._at(-1)
        return here if len(self.poses) < 2 else here + self.gap * (here - self._at(-2))

    def slow(self, unit: float) -> bool:
        """Whether it stays nearly where it is: only then can it be where something else was."""
        return len(self.poses) > 1 and self.speed < unit

    def rests(self, unit: float) -> bool:
        """Whether it has stayed where it is for all the frames that are remembered."""
        return len(self.poses) >= self.options.remembered_poses and self._farthest < 2 * unit

    @cached_property
    def _farthest(self) -> float:
        """Metres from where the centre is to the farthest place where it was."""
        path = np.vstack([transform(T, self.centre[None]) for T in self.poses])
        return float(np.linalg.norm(path - path[-1], axis=1).max())

    def _at(self, which: int) -> F64:
        pose = self.poses[which]
        return np.asarray(pose[:3, :3] @ self.centre + pose[:3, 3])

    @cached_property
    def predictions(self) -> F64:
        """(K, 4, 4) to try, the likeliest first: motion repeated, changing evenly, and at rest."""
        last, here = self.poses[-1], self._at(-1)
        if len(self.poses) < 2:
            return last[None]
        spin = last[:3, :3] @ self.poses[-2][:3, :3].T
        velocity = here - self._at(-2)
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
        result = [self._pose(turned, here + step)]
        result += [self._pose(kept, here + step), self._pose(kept, here)]
        if len(self.poses) > 2:
            result = [self._swung(turned), self._pose(turned, here + even), *result]
        if self.rested is not None:
            result.append(self.rested)
        return np.stack(result)

    def _swung(self, turned: F64) -> F64:
        """Turned about the point of the object that has moved the most evenly.

        In the air that is its centre of mass, in a hand it is near the grip.  Least squares over
        the second differences of the last poses, leaning on the centre.
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
    """The rotations nearest to some matrices (..., 3, 3)."""
    U, _, Vt = np.linalg.svd(R)
    return np.asarray(U @ Vt)


def _between(a: F64, b: F64, centre: F64, share: float) -> F64:
    """A pose on the way from ``a`` to ``b``; rotation is taken from ``b``."""
    start, end = transform(a, centre[None])[0], transform(b, centre[None])[0]
    T = b.copy()
    T[:3, 3] = start + share * (end - start) - b[:3, :3] @ centre
    return T
