"""A ray-caster for the tracking tests: capsules and boxes before a depth camera or a lidar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import PixelLattice, SensorPart


@dataclass(eq=False)
class Frame:
    """A TrackFrame in memory, with its truth."""

    xyz: np.ndarray
    rgb: np.ndarray | None = None
    truth: np.ndarray | None = None
    intensity: np.ndarray | None = None
    viewpoint: np.ndarray | None = None
    pose: np.ndarray | None = None
    lattice: PixelLattice | None = None
    sensor: np.ndarray | None = None
    parts: Sequence[SensorPart] = ()

    @cached_property
    def kdtree(self) -> cKDTree:
        return cKDTree(self.xyz, balanced_tree=False)


@dataclass
class Part:
    """A capsule from a to b with radii, or a box (centre, half size, rotation)."""

    label: int
    colour: tuple[float, float, float]
    a: np.ndarray
    b: np.ndarray
    ra: float = 0.0
    rb: float = 0.0
    rot: np.ndarray | None = None  # a box when given: a centre, b half size
    stripe: float = 0.0


@dataclass
class Sensor:
    """A depth camera, or a ``spherical`` lidar: pixels, metres, and how it stands in the world."""

    width: int = 256
    height: int = 212
    focal: float = 183.0
    origin: np.ndarray = field(default_factory=lambda: np.array([0.0, 1.5, 0.0]))
    look: np.ndarray = field(default_factory=lambda: np.eye(3))  # columns: right, up, forward
    spherical: bool = False
    noise: float = 0.0012

    @cached_property
    def rays(self) -> np.ndarray:
        """(N, 3) unit directions of the pixels, row by row, in the sensor's axes."""
        v, u = np.mgrid[0 : self.height, 0 : self.width]
        if self.spherical:
            az = (u + 0.5) / self.width * 2 * np.pi
            el = np.radians(np.linspace(8, -24, self.height))[v]
            d = np.stack([np.cos(el) * np.sin(az), np.sin(el), np.cos(el) * np.cos(az)], -1)
        else:
            d = np.stack(
                [
                    (u - self.width / 2 + 0.5) / self.focal,
                    -(v - self.height / 2 + 0.5) / self.focal,
                    np.ones(u.shape),
                ],
                -1,
            )
            d /= np.linalg.norm(d, axis=-1, keepdims=True)
        return d.reshape(-1, 3)


def _capsule(d: np.ndarray, pa: np.ndarray, pb: np.ndarray, ra: float, rb: float):
    """Rounded cone, Inigo Quilez's formula; ray origin at 0; returns t (inf), normals."""
    ba, oa, ob = pb - pa, -pa, -pb
    rr = ra - rb
    m0, m1, m2 = ba @ ba, ba @ oa, d @ ba
    m3, m5 = d @ oa, oa @ oa
    m6, m7 = d @ ob, ob @ ob
    d2 = m0 - rr * rr
    k2 = d2 - m2 * m2
    k1 = d2 * m3 - m1 * m2 + m2 * rr * ra
    k0 = d2 * m5 - m1 * m1 + m1 * rr * ra * 2 - m0 * ra * ra
    h = k1 * k1 - k0 * k2
    k2 = np.where(np.abs(k2) < 1e-12, 1e-12, k2)
    t = (-np.sqrt(np.maximum(h, 0)) - k1) / k2
    y = m1 - ra * rr + t * m2
    hit = (h >= 0) & (y > 0) & (y < d2)
    t = np.where(hit, t, np.inf)
    n = np.where(hit[:, None], (oa + t[:, None].clip(-1e6, 1e6) * d) * d2 - ba * y[:, None], 0)
    for mb, mc, r, o in ((m3, m5, ra, oa), (m6, m7, rb, ob)):
        hh = mb * mb - mc + r * r
        ts = np.where(hh > 0, -mb - np.sqrt(np.maximum(hh, 0)), np.inf)
        better = (ts < t) & (ts > 0) & ~hit
        t = np.where(better, ts, t)
        n = np.where(better[:, None], o + np.where(better, ts, 0)[:, None] * d, n)
    n /= np.linalg.norm(n, axis=1, keepdims=True) + 1e-12
    return np.where(t > 0.05, t, np.inf), n


def _box(d: np.ndarray, c: np.ndarray, half: np.ndarray, rot: np.ndarray):
    dl, ol = d @ rot, -c @ rot
    dl = np.where(np.abs(dl) < 1e-9, 1e-9, dl)
    t1, t2 = (-half - ol) / dl, (half - ol) / dl
    near, far = np.minimum(t1, t2), np.maximum(t1, t2)
    axis = np.argmax(near, 1)
    t = near.max(1)
    ok = (t < far.min(1)) & (t > 0.05)
    n = np.zeros_like(d)
    n[np.arange(len(d)), axis] = -np.sign(dl[np.arange(len(d)), axis])
    return np.where(ok, t, np.inf), n @ rot.T


def _intersect(part: Part, d: np.ndarray, origin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Metres (M,) along rays ``d`` (M, 3) to a part (inf: missed), and its normals (M, 3) there."""
    if part.rot is not None:
        return _box(d, part.a - origin, part.b, part.rot)
    return _capsule(d, part.a - origin, part.b - origin, part.ra, part.rb)


def _extent(part: Part) -> tuple[np.ndarray, float]:
    """Middle and radius of a ball around a part."""
    if part.rot is not None:
        return part.a, float(np.linalg.norm(part.b))
    return (part.a + part.b) / 2, float(np.linalg.norm(part.b - part.a) / 2) + max(part.ra, part.rb)


class Camera:
    """Sees moving parts before a static scene, which is cast once for each place of the sensor."""

    def __init__(self, sensor: Sensor, static: list[Part]) -> None:
        self.sensor = sensor
        self._static = static
        self._background: Hits | None = None
        self._seen_from = (b"", b"")

    def shoot(self, parts: list[Part], rng: np.random.Generator) -> Frame:
        """The points of a frame in the world's coordinates, in an order that tells nothing."""
        sensor = self.sensor
        directions = sensor.rays @ sensor.look.T
        place = (sensor.origin.tobytes(), sensor.look.tobytes())
        if self._background is None or self._seen_from != place:
            self._background, self._seen_from = Hits.none(len(directions)), place
            self._background.cast(self._static, sensor, directions)
        hits = self._background.copy()
        hits.cast(parts, sensor, directions)
        rgb = hits.shaded(rng)
        facing = np.abs((hits.normal * directions).sum(1)).clip(0.05)
        measured = _lidar if sensor.spherical else _time_of_flight
        ranges, valid = measured(sensor, hits.range, facing, rng)
        xyz = sensor.origin + directions * np.where(valid, ranges, 0)[:, None]
        order = rng.permutation(np.flatnonzero(valid))
        return Frame(
            xyz[order].astype(np.float32),
            rgb[order],
            hits.label[order],
            viewpoint=sensor.origin.astype(np.float64),
        )


@dataclass(eq=False)
class Hits:
    """What (N,) rays meet first: metres (inf: nothing), label, colour and normal (N, 3)."""

    range: np.ndarray
    label: np.ndarray
    colour: np.ndarray
    normal: np.ndarray

    @classmethod
    def none(cls, n: int) -> Hits:
        return cls(np.full(n, np.inf), np.zeros(n, np.uint16), np.zeros((n, 3)), np.zeros((n, 3)))

    def copy(self) -> Hits:
        return Hits(self.range.copy(), self.label.copy(), self.colour.copy(), self.normal.copy())

    def cast(self, parts: list[Part], sensor: Sensor, directions: np.ndarray) -> None:
        """Take in the parts that are nearer than what the rays met so far."""
        for part in parts:
            rays = _rays_near(part, sensor, directions)
            if not len(rays):
                continue
            ranges, normals = _intersect(part, directions[rays], sensor.origin)
            nearer = ranges < self.range[rays]
            rays = rays[nearer]
            points = sensor.origin + directions[rays] * ranges[nearer][:, None]
            self.range[rays] = ranges[nearer]
            self.label[rays] = part.label
            self.colour[rays] = _painted(part, points)
            self.normal[rays] = normals[nearer]

    def shaded(self, rng: np.random.Generator) -> np.ndarray:
        """(N, 3) uint8, lit from above, with noise."""
        light = np.array([0.3, 0.8, -0.5]) / np.linalg.norm([0.3, 0.8, -0.5])
        shade = 0.55 + 0.45 * np.abs(self.normal @ light)
        noisy = self.colour * shade[:, None] + rng.normal(0, 4, self.colour.shape)
        return np.clip(noisy, 0, 255).astype(np.uint8)


def _rays_near(part: Part, sensor: Sensor, directions: np.ndarray) -> np.ndarray:
    """Numbers of the rays that may meet a part, by the ball around it."""
    middle, radius = _extent(part)
    ahead = (middle - sensor.origin) @ sensor.look
    distance = np.linalg.norm(ahead)
    every = np.arange(len(directions))
    if distance <= radius * 1.05:
        return every
    if sensor.spherical:
        angle = np.arcsin(min(1, radius / distance))
        return np.flatnonzero(directions @ ((middle - sensor.origin) / distance) > np.cos(angle))
    if ahead[2] < -radius:
        return every[:0]
    if ahead[2] <= radius * 1.05:
        return every
    column = ahead[0] / ahead[2] * sensor.focal + sensor.width / 2
    row = -ahead[1] / ahead[2] * sensor.focal + sensor.height / 2
    reach = radius / (ahead[2] - radius) * sensor.focal * 1.2 + 3
    columns = np.arange(int(max(0, column - reach)), int(min(sensor.width, column + reach + 1)))
    rows = np.arange(int(max(0, row - reach)), int(min(sensor.height, row + reach + 1)))
    return (rows[:, None] * sensor.width + columns).ravel()


def _painted(part: Part, points: np.ndarray) -> np.ndarray:
    """(M, 3) colours of points on a part, striped along its axis."""
    colours = np.tile(np.array(part.colour, np.float64), (len(points), 1))
    if part.stripe:
        axis = part.b - part.a if part.rot is None else part.rot[:, 1]
        along = ((points - part.a) @ axis) / (axis @ axis) * (1 if part.rot is None else 4)
        colours[np.floor(along * part.stripe).astype(int) % 2 == 1] *= 0.35
    return colours


def _lidar(
    sensor: Sensor, ranges: np.ndarray, facing: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Noisy ranges (N,) up to 90 m, and which of them come back."""
    ranges = ranges + rng.normal(0, 0.015, len(ranges))
    return ranges, np.isfinite(ranges) & (ranges < 90) & (rng.random(len(ranges)) > 0.05)


def _time_of_flight(
    sensor: Sensor, ranges: np.ndarray, facing: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Noisy ranges (N,) up to 8 m, with flying pixels and holes at jumps, and which are valid.

    ``facing``: cosine between ray and normal; grazed surfaces send nothing back.
    """
    squared = np.where(np.isfinite(ranges), ranges, 0) ** 2
    ranges = ranges + rng.normal(0, 1, len(ranges)) * sensor.noise * (0.6 + 0.35 * squared)
    ranges[~np.isfinite(ranges)] = 99.0
    image = ranges.reshape(sensor.height, sensor.width)
    jump = np.zeros_like(image, bool)
    jump[:, 1:] |= np.abs(image[:, 1:] - image[:, :-1]) > 0.08
    flying = (jump & (rng.random(image.shape) < 0.35))[:, 1:]
    image[:, 1:][flying] += rng.random(int(flying.sum())) * (image[:, :-1] - image[:, 1:])[flying]
    ranges = image.ravel()
    valid = np.isfinite(ranges) & (ranges < 8) & (rng.random(len(ranges)) > 0.02) & (facing >= 0.12)
    valid &= ~(jump.ravel() & (rng.random(len(ranges)) < 0.3))
    return ranges, valid
