"""Small rigid-motion and curve helpers of the sample generator.

Room coordinates: x right, y up, z towards the camera, metres, the floor at y = 0 under the camera.
Matrices are float64 and name their direction, ``T_target_source``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.samples.reproducible import atan2, cos, inner, matmul, norm, sin

Array = NDArray[np.float64]
Field = NDArray[np.float32]
"""Per-pixel values of the renderer: (N,) or component-major (3, N)."""

UP: Array = np.array([0.0, 1.0, 0.0])
GRAVITY = 9.81


def vec(*values: float) -> Array:
    """Return the values as a float64 vector."""
    return np.array(values, dtype=np.float64)


def unit(v: Array) -> Array:
    """``v`` scaled to length one."""
    return np.asarray(v / norm(v))


def dot3(a: Field, b: Field) -> Field:
    """(N,) inner products of component-major vectors (3, N)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2], np.float32)


def norm3(a: Field) -> Field:
    """(N,) lengths of component-major vectors (3, N)."""
    return np.asarray(np.sqrt(dot3(a, a)), np.float32)


def axis_angle(axis: Array, angle: float) -> Array:
    """(3, 3) rotation by ``angle`` radians round ``axis`` (Rodrigues)."""
    x, y, z = unit(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + sin(angle) * K + (1.0 - cos(angle)) * matmul(K, K))


def yaw(angle: float) -> Array:
    """(3, 3) rotation round the vertical."""
    return axis_angle(UP, angle)


def turn_between(a: Array, b: Array) -> Array:
    """Rotation vector (3,) of the smallest rotation that takes unit ``a`` to unit ``b``."""
    axis = np.cross(a, b)
    sine = norm(axis)
    angle = atan2(sine, inner(a, b))
    if sine < 1e-9:
        return np.zeros(3) if angle < 1.0 else unit(np.cross(a, _other(a))) * math.pi
    return np.asarray(axis / sine * angle)


def from_rotation_vector(v: Array) -> Array:
    """(3, 3) rotation round ``v`` by its length."""
    angle = norm(v)
    return np.eye(3) if angle < 1e-12 else axis_angle(v, angle)


def rigid(R: Array, t: Array) -> Array:
    """(4, 4) transform of rotation ``R`` and translation ``t``."""
    T = np.eye(4)
    T[:3, :3] = R
    T[:3, 3] = t
    return T


def inverse(T: Array) -> Array:
    """Return the inverse of a rigid transform (4, 4)."""
    R = T[:3, :3].T
    return rigid(R, -matmul(R, T[:3, 3]))


def along(start: Array, end: Array, right: Array) -> Array:
    """(4, 4) frame at ``start``: its y axis points to ``end``, its x axis is near ``right``."""
    y = unit(end - start)
    x = right - inner(right, y) * y
    x = unit(x) if inner(x, x) > 1e-8 else unit(np.cross(y, _other(y)))
    return rigid(np.column_stack([x, y, np.cross(x, y)]), start)


def _other(v: Array) -> Array:
    """Return a coordinate axis that is not near ``v``."""
    return np.asarray(np.eye(3)[int(np.argmin(np.abs(v)))])


def smoothstep(x: float) -> float:
    """Ease from 0 to 1 over x in 0..1, level at both ends."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


def hermite(s: float, p0: Array, p1: Array, m0: Array, m1: Array) -> Array:
    """Cubic through ``p0`` (s = 0) and ``p1`` (s = 1) with tangents ``m0``, ``m1`` per unit s."""
    s2, s3 = s * s, s * s * s
    return (
        (2 * s3 - 3 * s2 + 1) * p0
        + (s3 - 2 * s2 + s) * m0
        + (3 * s2 - 2 * s3) * p1
        + (s3 - s2) * m1
    )


def two_bones(root: Array, target: Array, upper: float, lower: float, pole: Array) -> Array:
    """Middle joint of a two-bone limb from ``root`` that reaches for ``target``, bent to ``pole``.

    A target out of reach leaves the limb as good as straight.
    """
    reach = target - root
    distance = norm(reach)
    span = min(max(distance, abs(upper - lower) + 1e-3), upper + lower - 1e-3)
    direction = reach / max(distance, 1e-6)
    cosine = (upper * upper + span * span - lower * lower) / (2 * upper * span)
    bend = unit(pole - inner(pole, direction) * direction)
    return np.asarray(
        root + upper * (cosine * direction + math.sqrt(max(0.0, 1 - cosine * cosine)) * bend)
    )


def wobble(t: float, phases: Array, periods: Sequence[float]) -> float:
    """Smooth aperiodic motion in -1..1: a mean of sines."""
    waves = [sin(2 * math.pi * t / p + f) for f, p in zip(phases, periods, strict=True)]
    return math.fsum(waves) / len(waves)
