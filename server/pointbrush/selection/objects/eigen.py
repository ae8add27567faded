"""Eigenvalues of symmetric 3 x 3 matrices in closed form (Smith, CACM 4, 1961)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import innermost

Floats = NDArray[np.float64]


@innermost
def eigenvalues(
    xx: float, xy: float, xz: float, yy: float, yz: float, zz: float
) -> tuple[float, float, float]:
    """Return the eigenvalues, least first."""
    q = (xx + yy + zz) / 3
    off = xy * xy + xz * xz + yz * yz
    spread = (xx - q) ** 2 + (yy - q) ** 2 + (zz - q) ** 2 + 2 * off
    if spread <= 1e-300:
        return q, q, q
    p = np.sqrt(spread / 6)
    a, b, c = (xx - q) / p, (yy - q) / p, (zz - q) / p
    d, e, f = xy / p, xz / p, yz / p
    half = (a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)) / 2
    angle = np.arccos(min(1.0, max(-1.0, half))) / 3
    high = q + 2 * p * np.cos(angle)
    low = q + 2 * p * np.cos(angle + 2 * np.pi / 3)
    return low, 3 * q - high - low, high


@innermost
def eigenvector(
    xx: float, xy: float, xz: float, yy: float, yz: float, zz: float, value: float
) -> tuple[float, float, float]:
    """Return the unit eigenvector of ``value``: the longest cross product of two rows."""
    a, b, c = xx - value, yy - value, zz - value
    x0, y0, z0 = xy * yz - xz * b, xz * xy - a * yz, a * b - xy * xy
    x1, y1, z1 = xy * c - xz * yz, xz * xz - a * c, a * yz - xy * xz
    x2, y2, z2 = b * c - yz * yz, yz * xz - xy * c, xy * yz - b * xz
    n0 = x0 * x0 + y0 * y0 + z0 * z0
    n1 = x1 * x1 + y1 * y1 + z1 * z1
    n2 = x2 * x2 + y2 * y2 + z2 * z2
    if n1 > n0:
        x0, y0, z0, n0 = x1, y1, z1, n1
    if n2 > n0:
        x0, y0, z0, n0 = x2, y2, z2, n2
    if n0 <= 1e-300:
        return 0.0, 0.0, 1.0
    n0 = np.sqrt(n0)
    return x0 / n0, y0 / n0, z0 / n0
