"""Model of the Kinect 2: noise, flying and missing pixels, camera colour.

Depth.  Standard deviation ``0.9 mm + 0.4 mm * z**2`` (z in metres), more for dark and grazing
surfaces and in the corners; a part of it is shared by neighbouring pixels.  At depth edges the
sampling position jitters by up to a pixel, and some pixels mix the near and the far surface
(flying pixels).  Pixels are missing out of range, where too little infrared comes back, and as
speckle.  Depth is whole millimetres.

Truth of flying pixels: the label of the near or the far surface that it mixes, if it lies within
``FLYING_TOLERANCE`` of that one's depth, else 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter, minimum_filter, uniform_filter

from pointbrush.samples.geometry import Field

FLYING_TOLERANCE = 0.02
"""Metres from a surface within which a flying pixel still counts as its object."""

EDGE = 0.05
"""Depth step between neighbours, metres, that makes an edge."""

_AROUND = np.array([(r, c) for r in (-1, 0, 1) for c in (-1, 0, 1)]).T


@dataclass(frozen=True, slots=True)
class Sensor:
    """Settings of the depth and colour sensor.

    ``noise`` multiplies every random error (0: a perfect sensor without flying pixels or
    speckle); ``nearest`` and ``farthest`` bound the range in metres.
    """

    noise: float = 1.0
    nearest: float = 0.5
    farthest: float = 6.0
    exposure: float = 1.0


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
        white = rng.standard_normal((height, width), dtype=np.float32)
        shared = gaussian_filter(rng.standard_normal((height, width), dtype=np.float32), 1.2) * 4.2
        sigma = deviation(far) * weak * np.float32(sensor.noise)
        measured = measured + sigma * (0.8 * white + 0.6 * shared)
    lost = (measured < sensor.nearest) | (measured > sensor.farthest) | (strength <= 0)
    if sensor.noise > 0:
        chance = rng.random((height, width), dtype=np.float32)
        faint = np.clip((0.0045 - strength) / 0.0045, 0, 1) ** 2
        edge = (_span(far) > 2 * EDGE) * np.float32(0.12)
        lost |= chance < (faint + edge + np.float32(0.0012)) * np.float32(min(sensor.noise, 2))
    millimetres = np.round(measured * 1000)
    return Scan(np.where(lost, 0, millimetres / 1000).astype(np.float32), label)


def _vignette(height: int, width: int) -> Field:
    v, u = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    return np.asarray(1 / (1 + 0.55 * (u * u + v * v)) ** 2, np.float32)


def _span(depth: Field) -> Field:
    """Range of depth over each pixel's 3x3 neighbourhood."""
    return np.asarray(maximum_filter(depth, 3) - minimum_filter(depth, 3), np.float32)


def _jitter(
    depth: Field, label: NDArray[np.uint16], amplitude: Field, rng: np.random.Generator
) -> tuple[Field, NDArray[np.uint16], Field]:
    """Let edge pixels look a pixel aside now and then."""
    rows, columns = np.nonzero(_span(depth) > EDGE)
    offset = rng.normal(0, 0.42, (2, rows.size))
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
    reach = np.minimum(b - a, 1.5) * rng.beta(0.6, 1.1, rows.size).astype(np.float32)
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
    image = np.stack([gaussian_filter(channel, 0.55) for channel in light])
    image *= np.float32(sensor.exposure * gain)
    image = image / (1 + 0.22 * image) * np.float32(1.12)
    if sensor.noise > 0:
        shape = image.shape[1:]
        luma = rng.standard_normal(shape, dtype=np.float32)
        chroma = np.stack(
            [uniform_filter(rng.standard_normal(shape, dtype=np.float32), (2, 4)) for _ in range(3)]
        )
        level = np.sqrt(np.maximum(image.mean(axis=0), 0) * 0.00035 + 0.00002)
        image = image + (level * np.float32(sensor.noise)) * (0.7 * luma + 1.5 * chroma)
    encoded = np.clip(image, 0, 1) ** np.float32(1 / 2.2) * 255 + 0.5
    return np.ascontiguousarray(encoded.transpose(1, 2, 0)).astype(np.uint8)
