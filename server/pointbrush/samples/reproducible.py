"""Arithmetic that gives the same bits on every x86-64 processor.

BLAS and LAPACK (``@``, ``np.linalg``), and the sines and exponentials of NumPy and the C library,
have variants per processor that differ in the last bit.  One bit decides whether a ray meets an
edge, and the number of such pixels decides how many random numbers are drawn.

Samples therefore use +, -, *, / and sqrt, which IEEE 754 rounds correctly, each sum in one order,
and the functions below, which are made of these.  NumPy never fuses two such operations, and
SciPy's filters, splines and trees are compiled for the least processor only.  Rounding a library's
result would not do: some arguments lie beside a step of any grid.  It does for a few constants.

Random bits and uniform numbers are exact.  The ziggurat of the normal and of the exponential
distribution takes a logarithm in its tail alone, which is cut off; where it compares an exponential
with a random number, the last bit decides with a chance of about 1e-16.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

Array = NDArray[np.float64]
Rng = np.random.Generator

HALF_PI = (1.5707963267341256, 6.077100506506192e-11)
"""Upper 33 bits of pi / 2, and the rest: multiples of the first are exact."""
COSINE, SINE = (tuple(-1 / (k * (k + 1)) for k in range(last, 0, -2)) for last in (15, 16))
"""Ratios of the terms of the cosine's series and of the sine's, last first; enough to pi / 4."""
HALVINGS = 4
"""Halvings of an angle before the series of its arc tangent."""
ARC_TERMS = 12
"""Terms of the series of the arc tangent."""
NORMAL_TAIL = 3.65
"""Start of the tail in NumPy's ziggurat table of the normal distribution, rounded down."""
EXPONENTIAL_TAIL = 7.69
"""Start of the tail in NumPy's ziggurat table of the exponential distribution, rounded down."""


def matmul(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Return the matrix product of ``a`` (…, K) and ``b`` (K, N) or (K,), summed from the first."""
    if b.ndim == 1:
        return np.asarray(matmul(a, b[:, None])[..., 0])
    total = a[..., 0, None] * b[0]
    for k in range(1, len(b)):
        total += a[..., k, None] * b[k]
    return np.asarray(total)


def inner(a: Array, b: Array) -> float:
    """Return the inner product of two vectors (3,)."""
    x, y, z = (a * b).tolist()
    return float(x + y + z)


def norm(v: Array) -> float:
    """Return the length of a vector (3,)."""
    return math.sqrt(inner(v, v))


def norms(rows: Array) -> Array:
    """Return the lengths (N,) of vectors (N, 2) or (N, 3)."""
    return np.asarray(np.sqrt((rows * rows).T.sum(axis=0)))


def sin(angle: float) -> float:
    """Return the sine of ``angle`` radians."""
    return _wave(angle, 0)


def cos(angle: float) -> float:
    """Return the cosine of ``angle`` radians."""
    return _wave(angle, 1)


def sines(angle: NDArray[np.floating]) -> Array:
    """Return the sines of an array."""
    quarters = np.rint(angle.astype(np.float64) * (2 / math.pi))
    rest = angle - quarters * HALF_PI[0] - quarters * HALF_PI[1]
    square = rest * rest
    value = np.where(quarters % 2 == 1, _series(square, COSINE), rest * _series(square, SINE))
    return np.where(quarters % 4 < 2, value, -value)


def cosines(angle: NDArray[np.floating]) -> Array:
    """Return the cosines of an array."""
    return sines(angle + math.pi / 2)


def _wave(angle: float, ahead: int) -> float:
    """Return the sine, ``ahead`` quarters of a turn later."""
    quarters = round(angle * (2 / math.pi))
    rest = angle - quarters * HALF_PI[0] - quarters * HALF_PI[1]
    quarters += ahead
    square = rest * rest
    value = _series(square, COSINE) if quarters % 2 else rest * _series(square, SINE)
    return value if quarters % 4 < 2 else -value


@overload
def _series(square: float, ratios: Sequence[float]) -> float: ...
@overload
def _series(square: Array, ratios: Sequence[float]) -> Array: ...
def _series(square: Any, ratios: Sequence[float]) -> Any:
    """Sum a series; each term is the previous one times a ratio of ``ratios`` and ``square``."""
    value = 1.0 + ratios[0] * square
    for ratio in ratios[1:]:
        value *= square
        value *= ratio
        value += 1.0
    return value


def atan2(y: float, x: float) -> float:
    """Return the angle of (x, y) from the x axis, -pi to pi."""
    if x < 0:
        return math.copysign(math.pi, y) - atan2(y, -x)
    hypotenuse = math.sqrt(x * x + y * y)
    tangent = y / (hypotenuse + x) if hypotenuse else 0.0
    for _ in range(HALVINGS - 1):
        tangent /= 1 + math.sqrt(1 + tangent * tangent)
    square, value = tangent * tangent, 0.0
    for k in range(2 * ARC_TERMS - 1, 0, -2):
        value = 1.0 / k - square * value
    return float(2**HALVINGS) * tangent * value


def asin(x: float) -> float:
    """Return the arc sine."""
    return atan2(x, math.sqrt((1 - x) * (1 + x)))


@overload
def draw_normal(rng: Rng, deviation: float) -> float: ...
@overload
def draw_normal(rng: Rng, deviation: float, shape: int | tuple[int, ...]) -> Array: ...
def draw_normal(
    rng: Rng, deviation: float, shape: int | tuple[int, ...] | None = None
) -> float | Array:
    """Draw from a normal distribution about 0 without its tails."""
    drawn = np.asarray(rng.standard_normal(shape))
    np.clip(drawn, -NORMAL_TAIL, NORMAL_TAIL, out=drawn)
    drawn *= deviation
    return float(drawn) if shape is None else drawn


def draw_exponential(rng: Rng, mean: float, count: int) -> Array:
    """Draw (count,) from an exponential distribution without its tail."""
    return np.asarray(np.minimum(rng.standard_exponential(count), EXPONENTIAL_TAIL) * mean)


def gaussian_blur(image: NDArray[np.float32], deviation: float) -> NDArray[np.float32]:
    """Blur an image by a Gaussian of so many pixels.

    Its few weights are rounded so coarsely that the last bit of a library has no effect.
    """
    reach = int(4 * deviation + 0.5)
    offsets = [k / deviation for k in range(-reach, reach + 1)]
    weights = [round(math.exp(-0.5 * x * x), 12) for x in offsets]
    total = math.fsum(weights)
    for axis in (0, 1):
        image = correlate1d(image, [w / total for w in weights], axis)
    return image
