"""Procedural surface colours.

A texture maps metric points ``p`` (3, N) of a solid's own coordinates to linear albedo (3, N).
All are module-level functions of plain numbers, bound with ``functools.partial``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.ndimage import map_coordinates

from pointbrush.samples.geometry import Field
from pointbrush.samples.reproducible import cosines, sines

Texture = Callable[[Field], Field]
Color = tuple[float, float, float]

_TABLE = np.random.default_rng(2).random((32, 32, 32)).astype(np.float32)


def linear(color: str) -> Color:
    """Return the linear albedo of an sRGB colour "#rrggbb"."""
    r, g, b = (int(color[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return (round(r**2.2, 9), round(g**2.2, 9), round(b**2.2, 9))


def noise(p: Field, scale: float, octaves: int = 2) -> Field:
    """Return value noise (N,) in 0..1 with bumps at most ``scale`` metres wide."""
    total = np.zeros(p.shape[1], np.float32)
    weight, amount = 0.0, 1.0
    for octave in range(octaves):
        q = p * np.float32(2**octave / scale) + np.float32(7.3 * octave)
        total += np.float32(amount) * map_coordinates(_TABLE, q, order=1, mode="grid-wrap")
        weight += amount
        amount *= 0.55
    return np.asarray(total / np.float32(weight), np.float32)


def _hash(*cells: Field) -> Field:
    """(N,) a fixed random number in 0..1 for each tuple of whole cell numbers."""
    key = np.zeros(cells[0].shape, np.int64)
    for cell in cells:
        key = key * 73 + cell.astype(np.int64)
    return np.asarray(_TABLE.ravel()[(key * 2654435761 >> 7) % _TABLE.size])


def _paint(color: Color, amount: Field) -> Field:
    return np.asarray(np.array(color, np.float32)[:, None] * amount, np.float32)


def _mix(a: Field, b: Field, share: Field) -> Field:
    return np.asarray(a + (b - a) * share, np.float32)


def plain(p: Field, *, color: Color, grain: float = 0.12, scale: float = 0.08) -> Field:
    """One colour with a soft cloud of variation."""
    return _paint(color, 1 - grain + 2 * grain * noise(p, scale))


def cloth(p: Field, *, color: Color, fold: float = 0.10) -> Field:
    """Fabric: broad folds and a fine weave."""
    folds = noise(p * np.array([[1], [0.45], [1]], np.float32), fold, 3)
    return _paint(color, 0.62 + 0.76 * folds)


def striped(p: Field, *, color: Color, second: Color, width: float) -> Field:
    """Fabric with horizontal stripes along y."""
    wave = sines(p[1] * np.float32(2 * np.pi / width)).astype(np.float32)
    return _mix(cloth(p, color=color), cloth(p, color=second), np.clip(wave * 6 + 0.5, 0, 1))


def checked(p: Field, *, color: Color, second: Color, width: float) -> Field:
    """Fabric with crossing bands (a lumberjack's shirt)."""
    across = (p[0] / width % 1 < 0.5).astype(np.float32)
    upward = (p[1] / width % 1 < 0.5).astype(np.float32)
    return _mix(cloth(p, color=color), cloth(p, color=second), (across + upward) / 2)


def planks(p: Field, *, color: Color, width: float = 0.14, length: float = 1.3) -> Field:
    """Wooden floor in the x-z plane, boards along x."""
    row = np.floor(p[2] / width)
    shifted = p[0] + _hash(row) * length
    board = np.floor(shifted / length)
    tone = 0.72 + 0.5 * _hash(row, board)
    stretched = np.stack([p[0] * 0.06, p[2] + tone, p[1]])
    grain = 0.8 + 0.4 * noise(stretched, 0.022, 3)
    gap = np.minimum(np.abs(p[2] / width - row - 0.5) * -1 + 0.5, 1) * width
    seam = np.minimum(gap, (shifted / length - board) * length)
    dark = np.clip(seam / 0.006, 0.35, 1)
    return _paint(color, tone * grain * dark)


def wood(p: Field, *, color: Color, along: int = 0) -> Field:
    """Timber with its grain along an axis."""
    stretch = np.full((3, 1), 1, np.float32)
    stretch[along] = 0.07
    return _paint(color, 0.75 + 0.5 * noise(p * stretch, 0.03, 3))


def wallpaper(p: Field, *, color: Color, axis: int = 0, width: float = 0.22) -> Field:
    """Wall with faint vertical stripes, stains and roller marks."""
    stripe = np.floor(p[axis] / (width / 2)) % 2
    return _paint(color, 0.93 + 0.06 * stripe + 0.10 * (noise(p, 0.9, 3) - 0.5))


def weave(p: Field, *, color: Color, second: Color, border: Color, half: Color) -> Field:
    """Rug in the x-z plane: a border, then diamonds; ``half`` its half extents."""
    edge = np.minimum(half[0] - np.abs(p[0]), half[2] - np.abs(p[2]))
    diamond = (np.abs((p[0] / 0.34) % 1 - 0.5) + np.abs((p[2] / 0.34) % 1 - 0.5) < 0.32) * 1.0
    field = _mix(plain(p, color=color), plain(p, color=second), diamond.astype(np.float32))
    line = ((edge < 0.14) & (edge > 0.03)).astype(np.float32)
    worn = np.asarray(0.8 + 0.4 * noise(p, 0.012, 1), np.float32)
    return np.asarray(_mix(field, plain(p, color=border), line) * worn)


def books(p: Field, *, width: float = 0.034) -> Field:
    """Backs of books along x, each of its own colour, with a title bar."""
    number = np.floor(p[0] / width + 0.35 * sines(np.floor(p[0] / width * 0.5)))
    hue = _hash(number)
    tone = 0.12 + 0.5 * _hash(number, number + 3)
    color = 0.5 + 0.5 * cosines(6.28 * (hue + np.array([[0.0], [0.33], [0.62]], np.float32)))
    title = (np.abs(p[1] - 0.02) < 0.02 + 0.02 * hue) & (_hash(number + 9) > 0.4)
    gap = np.clip((p[0] / width % 1) * 9, 0.15, 1)
    return np.asarray((0.25 + 0.75 * color) * tone * gap + title * 0.35, np.float32)


def poster(p: Field, *, seed: float, half: tuple[float, float], size: float = 0.42) -> Field:
    """A print in the x-y plane: soft shapes of a few inks in a white margin."""
    q = np.stack([p[0], p[1], np.full_like(p[0], seed)])
    a, b = noise(q, size, 2), noise(q + 3, size * 0.7, 2)
    inks = np.array([[0.75, 0.25, 0.08], [0.05, 0.17, 0.30], [0.85, 0.62, 0.25]], np.float32)
    inks = np.roll(inks, int(seed) % 3, axis=1)
    field = np.where(
        a > 0.56, inks[0][:, None], np.where(b > 0.52, inks[1][:, None], inks[2][:, None])
    )
    margin = (np.abs(p[0]) > half[0] - 0.03) | (np.abs(p[1]) > half[1] - 0.03)
    return np.asarray(np.where(margin, np.float32(0.8), field))


def banded(p: Field, *, bands: tuple[tuple[float, Color], ...]) -> Field:
    """Colours by height: each band reaches from the previous limit to its own (metres along y)."""
    result = np.empty_like(p)
    low = -np.inf
    for limit, color in bands:
        inside = (p[1] > low) & (p[1] <= limit)
        result[:, inside] = np.array(color, np.float32)[:, None]
        low = limit
    return np.asarray(result * (0.9 + 0.2 * noise(p, 0.02, 1)), np.float32)


def face(p: Field, *, skin: Color, hair: Color, hairline: float) -> Field:
    """A head of unit half-height 0.12 m: skin, eyes, brows, mouth, hair above; it looks along z."""
    color = _paint(skin, 0.9 + 0.2 * noise(p, 0.05))
    front = p[2] > 0
    square = ((np.abs(p[0]) - 0.04) / 0.02) ** 2 + ((p[1] + 0.03) / 0.02) ** 2
    cheeks = (np.maximum(1 - square / 4, 0) ** 2) ** 2
    color *= 1 + np.array([[0.10], [-0.12], [-0.12]], np.float32) * (cheeks * front)
    eyes = (np.abs(np.abs(p[0]) - 0.032) < 0.012) & (np.abs(p[1] - 0.012) < 0.007) & front
    brows = (np.abs(np.abs(p[0]) - 0.032) < 0.018) & (np.abs(p[1] - 0.034) < 0.005) & front
    mouth = (np.abs(p[0]) < 0.024) & (np.abs(p[1] + 0.058) < 0.006) & front
    line = hairline - 0.35 * (p[2] + 0.02) * (p[2] < 0.03) + 0.02 * (noise(p, 0.02) - 0.5)
    dark = _paint(hair, 0.6 + 0.8 * noise(p, 0.012))
    color[:, mouth] *= np.array([[0.75], [0.45], [0.45]], np.float32)
    color[:, eyes] = 0.04
    color[:, brows] = dark[:, brows]
    scalp = p[1] > line + 0.10 * np.clip(p[2] / 0.09, -1.6, 0.2)
    return np.asarray(np.where(scalp, dark, color), np.float32)


@dataclass(frozen=True, slots=True)
class Material:
    """A texture, and its response to light and the sensor's infrared (0 returns no depth)."""

    texture: Texture
    infrared: float = 0.55
    gloss: float = 0.0
    glow: float = 0.0


def matte(color: str, *, grain: float = 0.12, infrared: float = 0.55) -> Material:
    """Return a plain dull material of an sRGB colour."""
    return Material(partial(plain, color=linear(color), grain=grain), infrared)


def shiny(color: str, *, gloss: float = 0.5, infrared: float = 0.45) -> Material:
    """Return a plain material with a highlight."""
    return Material(partial(plain, color=linear(color), grain=0.05), infrared, gloss)
