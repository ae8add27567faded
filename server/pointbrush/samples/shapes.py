"""Canonical solids and their first intersections with rays.

Each shape is met by rays ``o + t d`` in its own unit coordinates; the renderer places it by a
rigid pose and a scale, and ``t`` is kept by that map.  Rays start outside and are component-major
float32: ``o`` (3,), ``d`` (3, N).  A miss is ``inf``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from pointbrush.samples.geometry import Array, Field, dot3, norm3, vec

MISS = np.float32(np.inf)


class Shape(Protocol):
    """Interface of a solid to the renderer."""

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper corner (3,) of the solid's own box."""

    def hit(self, o: Field, d: Field) -> Field:
        """(N,) ray parameter of the first meeting, inf for a miss."""

    def normal(self, p: Field) -> Field:
        """(3, N) outward normals, of any length, at surface points ``p`` (3, N)."""


def _sphere(oc: Field, d: Field, dd: Field, radius: float) -> Field:
    """First meeting with a ball; ``oc`` origin minus centre, ``dd`` squared length of ``d``."""
    b = dot3(oc, d)
    h = b * b - dd * (dot3(oc, oc) - np.float32(radius * radius))
    return np.asarray(np.where(h > 0, (-b - np.sqrt(np.maximum(h, 0))) / dd, MISS), np.float32)


class _Unit:
    """A solid that just fits the cube -1..1."""

    __slots__ = ()

    @property
    def bounds(self) -> tuple[Array, Array]:
        return vec(-1, -1, -1), vec(1, 1, 1)


@dataclass(frozen=True, slots=True)
class Ball(_Unit):
    """Unit ball; an ellipsoid by scale."""

    def hit(self, o: Field, d: Field) -> Field:
        return _sphere(o, d, dot3(d, d), 1.0)

    def normal(self, p: Field) -> Field:
        return p


@dataclass(frozen=True, slots=True)
class Box(_Unit):
    """The cube -1..1."""

    def hit(self, o: Field, d: Field) -> Field:
        with np.errstate(divide="ignore"):
            inverse = 1.0 / np.where(d == 0, np.float32(1e-20), d)
        a = (-1 - o)[:, None] * inverse
        b = (1 - o)[:, None] * inverse
        near = np.minimum(a, b).max(axis=0)
        far = np.maximum(a, b).min(axis=0)
        return np.where((near < far) & (near > 0), near, MISS)

    def normal(self, p: Field) -> Field:
        face = np.abs(p).argmax(axis=0)
        n = np.zeros_like(p)
        columns = np.arange(p.shape[1])
        n[face, columns] = np.sign(p[face, columns])
        return n


@dataclass(frozen=True, slots=True)
class RoundCone:
    """Hull of a ball of radius ``ra`` at the origin and one of ``rb`` at (0, ``length``, 0)."""

    ra: float
    rb: float
    length: float

    @property
    def bounds(self) -> tuple[Array, Array]:
        r = max(self.ra, self.rb)
        return vec(-r, -self.ra, -r), vec(r, self.length + self.rb, r)

    def hit(self, o: Field, d: Field) -> Field:
        """See Shape; the cone's quadratic as in Quilez, "Rounded cone - intersection"."""
        speed = norm3(d)
        d = np.asarray(d / speed, np.float32)
        ones = np.ones_like(speed)
        top = o - np.array([0, self.length, 0], np.float32)
        t = np.minimum(_sphere(o, d, ones, self.ra), _sphere(top, d, ones, self.rb))
        slope, edge = self.ra - self.rb, self.length * self.ra
        span = self.length * self.length - slope * slope
        m1, m2, m3 = self.length * float(o[1]), self.length * d[1], dot3(o, d)
        k2 = span - m2 * m2
        k1 = span * m3 - m1 * m2 + m2 * (slope * self.ra)
        k0 = span * float(dot3(o, o)) - m1 * m1 + 2 * m1 * slope * self.ra - edge * edge
        h = k1 * k1 - k0 * k2
        with np.errstate(divide="ignore", invalid="ignore"):
            side = (-k1 - np.sqrt(np.maximum(h, 0))) / k2
        y = m1 - self.ra * slope + side * m2
        good = (h > 0) & (k2 > 1e-7) & (y > 0) & (y < span)
        return np.asarray(np.where(good, np.minimum(t, side), t) / speed, np.float32)

    def normal(self, p: Field) -> Field:
        slope = self.ra - self.rb
        span = self.length * self.length - slope * slope
        y = self.length * p[1] - self.ra * slope
        n = p.copy()
        n[1] -= np.clip(y * (self.length / span), 0, self.length)
        return n


@dataclass(frozen=True, slots=True)
class Cylinder(_Unit):
    """Radius 1 round y, capped at y = -1 and 1."""

    def hit(self, o: Field, d: Field) -> Field:
        near, far = _cylinder_span(o, d)
        return np.where((near < far) & (near > 0), near, MISS)

    def normal(self, p: Field) -> Field:
        n = p.copy()
        side = p[0] * p[0] + p[2] * p[2] > np.abs(p[1])
        n[1] = np.where(side, 0, p[1])
        n[0] = np.where(side, p[0], 0)
        n[2] = np.where(side, p[2], 0)
        return n


class Lathe:
    """A surface of revolution round y, from a smooth profile of radii.

    ``heights`` (K,) ascending, ``radii`` (K,): the profile's knots, joined by a monotone cubic.
    """

    STEPS = 20

    def __init__(self, heights: list[float], radii: list[float]) -> None:
        self._y = np.linspace(heights[0], heights[-1], 400).astype(np.float32)
        curve = PchipInterpolator(heights, radii)
        self._r = np.asarray(curve(self._y), np.float32)
        self._slope = np.asarray(curve(self._y, 1), np.float32)

    @property
    def bounds(self) -> tuple[Array, Array]:
        r = float(self._r.max())
        return vec(-r, float(self._y[0]), -r), vec(r, float(self._y[-1]), r)

    def radius(self, y: Field) -> Field:
        """(N,) profile radius at heights ``y``; negative beyond the ends."""
        inside = (y >= self._y[0]) & (y <= self._y[-1])
        return np.where(inside, np.interp(y, self._y, self._r), -1e-3).astype(np.float32)

    def hit(self, o: Field, d: Field) -> Field:
        """See Shape: march the stretch inside the bounding cylinder, then bisect."""
        lo, hi = self.bounds
        middle, half = (lo[1] + hi[1]) / 2, (hi[1] - lo[1]) / 2
        stretch = np.array([hi[0], half, hi[0]], np.float32) * np.float32(1.001)
        centre = np.array([0, middle, 0], np.float32)
        near, far = _cylinder_span((o - centre) / stretch, d / stretch[:, None])
        result = np.full(d.shape[1], MISS, np.float32)
        rays = np.flatnonzero(near < far)
        if not rays.size:
            return result
        d, near, far = d[:, rays], near[rays], far[rays]
        steps = np.linspace(0, 1, self.STEPS, dtype=np.float32)[:, None]
        t = near + (far - near) * steps
        inside = self._inside(o, d, t)
        entered = inside.any(axis=0)
        first = np.maximum(inside.argmax(axis=0), 1)
        columns = np.arange(rays.size)
        before, after = t[first - 1, columns], t[first, columns]
        for _ in range(10):
            halfway = (before + after) / 2
            within = self._inside(o, d, halfway)
            after = np.where(within, halfway, after)
            before = np.where(within, before, halfway)
        result[rays] = np.where(entered, after, MISS)
        return result

    def _inside(self, o: Field, d: Field, t: Field) -> NDArray[np.bool_]:
        x, y, z = o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]
        r = self.radius(y)
        return np.asarray((r > 0) & (x * x + z * z <= r * r))

    def normal(self, p: Field) -> Field:
        slope = np.interp(p[1], self._y, self._slope).astype(np.float32)
        n = p.copy()
        n[1] = -slope * np.sqrt(p[0] * p[0] + p[2] * p[2])
        ends = (p[1] < self._y[1]) | (p[1] > self._y[-2])
        n[1] = np.where(ends, np.sign(p[1] - self._y[200]) * 0.05, n[1])
        return n


def _cylinder_span(o: Field, d: Field) -> tuple[Field, Field]:
    """(N,) entry and exit of the unit cylinder; a miss has entry after exit."""
    a = np.maximum(d[0] * d[0] + d[2] * d[2], np.float32(1e-12))
    b = o[0] * d[0] + o[2] * d[2]
    h = b * b - a * (o[0] * o[0] + o[2] * o[2] - 1)
    root = np.sqrt(np.maximum(h, 0))
    slope = np.where(d[1] == 0, np.float32(1e-12), d[1])
    low, high = (-1 - o[1]) / slope, (1 - o[1]) / slope
    near = np.maximum((-b - root) / a, np.minimum(low, high))
    far = np.minimum((-b + root) / a, np.maximum(low, high))
    return np.where(h > 0, near, MISS), far
