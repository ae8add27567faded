"""Sensors of the samples: a Kinect 2 on a tripod with its errors, and a spinning lidar.

A Kinect measures with noise and with flying and missing pixels, and its camera gives the colours;
a lidar turns rings of rays round itself once a frame.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter, uniform_filter

from pointbrush.frame import DepthCamera
from pointbrush.samples.geometry import Array, Field, axis_angle, norm3, rigid, vec
from pointbrush.samples.render import Solid
from pointbrush.samples.reproducible import (
    asin,
    atan2,
    cos,
    cosines,
    draw_exponential,
    draw_normal,
    gaussian_blur,
    matmul,
    norm,
    sin,
    sines,
)

KINECT = DepthCamera(width=512, height=424, fx=365.456, fy=365.456, cx=254.878, cy=205.395)
"""Intrinsics of a Kinect for Xbox One depth sensor (factory calibration of one unit)."""

FPS = 30.0
FLYING_TOLERANCE = 0.02
"""Metres from a surface within which a flying pixel still counts as its object."""

EDGE = 0.05
"""Depth step between neighbours, metres, that makes an edge."""

_TONES = (np.linspace(0, 1, 2**16) ** (1 / 2.2) * 255 + 0.5).astype(np.uint8)
"""Tone by linear light; no value is so near a step that the last bit of a library matters."""

_AROUND = np.array([(r, c) for r in (-1, 0, 1) for c in (-1, 0, 1)]).T


def pixel_rays(camera: DepthCamera) -> Field:
    """(3, H*W) directions of the pixels in camera coordinates, z = 1; so depth = ray parameter."""
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    x = (u.ravel() - camera.cx) / camera.fx
    y = (v.ravel() - camera.cy) / camera.fy
    return np.stack([x, y, np.ones_like(x)]).astype(np.float32)


def tripod(height: float, pitch_degrees: float) -> Array:
    """``T_room_camera`` of a camera above the room's origin that looks along -z and down."""
    flip = np.diag([1.0, -1.0, -1.0])  # camera: x right, y down, z forward
    return rigid(
        matmul(axis_angle(vec(-1, 0, 0), math.radians(pitch_degrees)), flip), vec(0, height, 0)
    )


@dataclass(frozen=True, slots=True)
class Sensor:
    """Settings of the depth and colour sensor.

    ``noise`` multiplies every random error (0: a perfect sensor without flying pixels or
    speckle), ``grain`` only that of depths; ``nearest`` and ``farthest`` bound the range in metres.
    """

    noise: float = 1.0
    nearest: float = 0.5
    farthest: float = 6.0
    exposure: float = 1.0
    grain: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """A measured frame: ``depth`` (H, W) metres, 0 missing; ``label`` (H, W) truth."""

    depth: Field
    label: NDArray[np.uint16]


def deviation(depth: Field) -> Field:
    """Standard deviation, metres, of depth on a bright surface at the picture's centre."""
    return np.asarray(0.0009 + 0.0004 * depth * depth, np.float32)


def measure(
    sensor: Sensor,
    depth: Field,
    label: NDArray[np.uint16],
    amplitude: Field,
    rng: np.random.Generator,
) -> Scan:
    """Measure a perfect picture, all (H, W): depth (inf: nothing), labels, returned infrared.

    ``amplitude`` is infrared reflectance times the cosine of incidence, 0..1.
    """
    height, width = depth.shape
    far = np.where(np.isfinite(depth), depth, 20).astype(np.float32)
    if sensor.noise > 0:
        far, label, amplitude = _jitter(far, label, amplitude, rng)
    bright = amplitude * _vignette(height, width)
    strength = bright / np.maximum(far, 0.3) ** 2
    measured = far
    if sensor.noise > 0:
        measured, label = _fly(far, label, rng, sensor.noise)
        weak = np.clip(0.45 / np.maximum(bright, 1e-4), 0.8, 2.5)
        white = _grain(rng, depth.shape)
        shared = gaussian_blur(_grain(rng, depth.shape), 1.2) * 4.2
        sigma = deviation(far) * weak * np.float32(sensor.noise * sensor.grain)
        measured = measured + sigma * (0.8 * white + 0.6 * shared)
    lost = (measured < sensor.nearest) | (measured > sensor.farthest) | (strength <= 0)
    if sensor.noise > 0:
        chance = rng.random((height, width), dtype=np.float32)
        faint = np.clip((0.0045 - strength) / 0.0045, 0, 1) ** 2
        edge = (_span(far) > 2 * EDGE) * np.float32(0.12)
        lost |= chance < (faint + edge + np.float32(0.0012)) * np.float32(min(sensor.noise, 2))
    millimetres = np.round(measured * 1000)
    return Scan(np.where(lost, 0, millimetres / 1000).astype(np.float32), label)


def _grain(rng: np.random.Generator, shape: tuple[int, ...]) -> Field:
    return draw_normal(rng, 1.0, shape).astype(np.float32)


def _vignette(height: int, width: int) -> Field:
    v, u = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    return np.asarray(1 / (1 + 0.55 * (u * u + v * v)) ** 2, np.float32)


def _span(depth: Field) -> Field:
    """Range of depth over each pixel's 3x3 neighbourhood."""
    return np.asarray(maximum_filter(depth, 3) - minimum_filter(depth, 3), np.float32)


def _jitter(
    depth: Field, label: NDArray[np.uint16], amplitude: Field, rng: np.random.Generator
) -> tuple[Field, NDArray[np.uint16], Field]:
    """Replace some edge pixels by a neighbour."""
    rows, columns = np.nonzero(_span(depth) > EDGE)
    offset = draw_normal(rng, 0.42, (2, rows.size))
    r = np.clip(np.rint(rows + offset[0]), 0, depth.shape[0] - 1).astype(np.intp)
    c = np.clip(np.rint(columns + offset[1]), 0, depth.shape[1] - 1).astype(np.intp)
    depths, labels, amplitudes = depth.copy(), label.copy(), amplitude.copy()
    depths[rows, columns] = depth[r, c]
    labels[rows, columns] = label[r, c]
    amplitudes[rows, columns] = amplitude[r, c]
    return depths, labels, amplitudes


def _fly(
    depth: Field, label: NDArray[np.uint16], rng: np.random.Generator, noise: float
) -> tuple[Field, NDArray[np.uint16]]:
    """Mix the nearest and the farthest depth round some edge pixels."""
    height, width = depth.shape
    near, far = minimum_filter(depth, 3), maximum_filter(depth, 3)
    rows, columns = np.nonzero((far - near > EDGE) & (near < 8))
    chosen = rng.random(rows.size) < min(0.30 * noise, 0.8)
    rows, columns = rows[chosen], columns[chosen]
    r = np.clip(rows + _AROUND[0][:, None], 0, height - 1)
    c = np.clip(columns + _AROUND[1][:, None], 0, width - 1)
    around, each = depth[r, c], np.arange(rows.size)
    low, high = around.argmin(axis=0), around.argmax(axis=0)
    a, b = around[low, each], around[high, each]
    root = np.sqrt(rng.random(rows.size))
    share = root * root * root * np.sqrt(root)  # as good as a beta distribution, 0.6 and 1.1
    reach = np.minimum(b - a, 1.5) * share.astype(np.float32)
    flown, truth = depth.copy(), label.copy()
    flown[rows, columns] = a + reach
    by_near, by_far = label[r, c][low, each], label[r, c][high, each]
    on_far = np.where(b - a - reach <= FLYING_TOLERANCE, by_far, 0)
    truth[rows, columns] = np.where(reach <= FLYING_TOLERANCE, by_near, on_far)
    return flown, truth


def develop(
    sensor: Sensor, light: Field, rng: np.random.Generator, gain: float = 1.0
) -> NDArray[np.uint8]:
    """(H, W, 3) sRGB picture of linear light (3, H, W): lens blur, noise, tone curve."""
    image = np.stack([gaussian_blur(channel, 0.55) for channel in light])
    image *= np.float32(sensor.exposure * gain)
    image = image / (1 + 0.22 * image) * np.float32(1.12)
    if sensor.noise > 0:
        shape = image.shape[1:]
        luma = _grain(rng, shape)
        chroma = np.stack([uniform_filter(_grain(rng, shape), (2, 4)) for _ in range(3)])
        level = np.sqrt(np.maximum(image.mean(axis=0), 0) * 0.00035 + 0.00002)
        image = image + (level * np.float32(sensor.noise)) * (0.7 * luma + 1.5 * chroma)
    level = np.clip(image, 0, 1) * np.float32(_TONES.size - 1)
    return _TONES[np.ascontiguousarray(level.transpose(1, 2, 0)).astype(np.uint16)]


@dataclass(frozen=True, slots=True)
class Spinner:
    """``rings`` rays between ``lowest`` and ``highest`` (degrees), ``steps`` a turn.

    ``noise`` standard deviation of the range, ``farthest`` return: metres; ``lost`` share of rays
    that give none.
    """

    rings: int = 64
    lowest: float = -24.8
    highest: float = 2.0
    steps: int = 1800
    noise: float = 0.02
    farthest: float = 100.0
    lost: float = 0.04


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """``xyz`` (N, 3) metres in the solids' coordinates, ``intensity`` (N,) 0..1, ``label`` (N,)."""

    xyz: Array
    intensity: NDArray[np.float32]
    label: NDArray[np.uint16]


def spin(spinner: Spinner, eye: Array, solids: Sequence[Solid], rng: np.random.Generator) -> Turn:
    """Cast the rays of one turn at ``eye`` (3,); solids of roughness 1 and more are foliage, which
    rays enter or pass."""
    up = np.radians(np.linspace(spinner.lowest, spinner.highest, spinner.rings))
    up = up + draw_normal(rng, 0.0004, spinner.rings)
    azimuth = np.arange(spinner.steps) * (2 * math.pi / spinner.steps)
    level, high = cosines(up)[:, None], sines(up)[:, None]
    # x right, y up, z toward the viewer: azimuth from x to -z.
    axes = np.broadcast_arrays(level * cosines(azimuth), high, -level * sines(azimuth))
    rays: Field = np.stack(axes).reshape(3, -1).astype(np.float32)
    depth = np.full(rays.shape[1], np.inf, np.float32)
    owner = np.full(rays.shape[1], -1, np.int32)
    for number, solid in enumerate(solids):
        aimed = _aimed(spinner, solid, eye)
        if len(aimed):
            t = _meet(solid, eye, rays[:, aimed], rng)
            nearer = t < depth[aimed]
            depth[aimed[nearer]], owner[aimed[nearer]] = t[nearer], number
    kept = (owner >= 0) & (depth < spinner.farthest) & (rng.random(depth.size) > spinner.lost)
    return _returns(spinner, eye, solids, rays[:, kept], depth[kept], owner[kept], rng)


def _aimed(spinner: Spinner, solid: Solid, eye: Array) -> NDArray[np.intp]:
    """Return the indices of rays that may meet a solid: rays toward the ball round its box."""
    lo, hi = (bound * solid.scale for bound in solid.shape.bounds)
    middle = matmul(solid.pose[:3, :3], (lo + hi) / 2) + solid.pose[:3, 3] - eye
    radius = norm(hi - lo) / 2
    distance = norm(middle)
    if distance <= radius * 1.05:
        return np.arange(spinner.rings * spinner.steps)
    half = asin(radius / distance)
    elevation = asin(float(middle[1]) / distance)
    span = math.radians(spinner.highest - spinner.lowest) / (spinner.rings - 1)
    first = math.floor((elevation - half - math.radians(spinner.lowest)) / span)
    last = math.ceil((elevation + half - math.radians(spinner.lowest)) / span)
    rings = np.arange(max(first, 0), min(last + 1, spinner.rings))
    ratio = sin(half) / max(cos(elevation), 1e-6)
    wide = asin(ratio) if ratio < 1 else math.pi
    step = 2 * math.pi / spinner.steps
    toward = atan2(-float(middle[2]), float(middle[0]))
    reach = min(math.ceil(wide / step) + 1, spinner.steps // 2)
    columns = np.unique((round(toward / step) + np.arange(-reach, reach + 1)) % spinner.steps)
    return np.asarray((rings[:, None] * spinner.steps + columns).ravel(), np.intp)


def _meet(solid: Solid, eye: Array, rays: Field, rng: np.random.Generator) -> Field:
    inverse = solid.pose[:3, :3].T / solid.scale[:, None]
    o = matmul(inverse, eye - solid.pose[:3, 3]).astype(np.float32)
    t = solid.shape.hit(o, matmul(inverse.astype(np.float32), rays))
    if solid.roughness >= 1:
        deeper = draw_exponential(rng, 0.35, t.size).astype(np.float32)
        t = np.where(rng.random(t.size) < 0.35, np.float32(np.inf), t + deeper)
    return np.asarray(t, np.float32)


def _returns(
    spinner: Spinner,
    eye: Array,
    solids: Sequence[Solid],
    rays: Field,
    depth: Field,
    owner: NDArray[np.int32],
    rng: np.random.Generator,
) -> Turn:
    exact = eye[:, None] + rays * depth
    strength = np.empty(depth.size, np.float32)
    labels = np.array([solid.label for solid in solids], np.uint16)
    for number in np.unique(owner):
        on = np.flatnonzero(owner == number)
        solid = solids[int(number)]
        metric = matmul(solid.pose[:3, :3].T, exact[:, on] - solid.pose[:3, 3][:, None])
        scale = solid.scale[:, None]
        n = np.asarray(solid.shape.normal(np.asarray(metric / scale, np.float32)) / scale)
        n = matmul(solid.pose[:3, :3], n) / np.maximum(norm3(np.asarray(n, np.float32)), 1e-9)
        facing = np.abs((n * rays[:, on]).sum(axis=0))
        tone = solid.material.texture(np.asarray(metric, np.float32)).mean(axis=0)
        strength[on] = tone * (0.3 + 0.7 * facing)
    strength *= rng.uniform(0.85, 1.15, depth.size).astype(np.float32)
    measured = depth + draw_normal(rng, spinner.noise, depth.size)
    xyz = (eye[:, None] + rays * measured).T
    return Turn(xyz, np.clip(strength, 0, 1), labels[owner])
