"""A picture of where two annotations of a frame differ."""

from __future__ import annotations

import io
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

SIZE = 720
"""Pixels of the longer side."""
DOT = 2
"""Pixels of a point's side; of one that differs twice as many."""
MARGIN = 0.15
"""Around the labelled points, as a share of their extent."""
OUTLIERS = 1.0
"""Percent of points at each end that do not decide what is shown."""
BACKGROUND = (17, 19, 24)


class Difference(IntEnum):
    """Comparison of two annotations at a point, in the order in which it is drawn."""

    UNLABELLED = 0
    SAME = 1
    FIRST = 2
    SECOND = 3
    OTHER = 4


COLORS = {
    Difference.UNLABELLED: (58, 62, 72),
    Difference.SAME: (150, 156, 168),
    Difference.FIRST: (64, 156, 255),
    Difference.SECOND: (255, 159, 28),
    Difference.OTHER: (255, 64, 129),
}
"""Told apart by people who see red and green alike."""


def draw(places: NDArray[np.float64], what: NDArray[np.uint8]) -> bytes:
    """Return a PNG of points at (N, 2), right and down in metres, that are ``what`` (N,)."""
    from PIL import Image  # a server that answers has not loaded it

    low, high = _window(places, what)
    scale = SIZE / max(float((high - low).max()), 1e-6)
    width, height = (max(1, int(np.ceil(side * scale))) for side in (high - low))
    canvas = np.empty((height, width, 3), np.uint8)
    canvas[:] = BACKGROUND
    pixels = np.floor((places - low) * scale).astype(np.int64)
    for kind, color in COLORS.items():
        _dots(canvas, pixels[what == kind], color, DOT * (1 + (kind >= Difference.FIRST)))
    out = io.BytesIO()
    Image.fromarray(canvas).save(out, "PNG")
    return out.getvalue()


def _window(
    places: NDArray[np.float64], what: NDArray[np.uint8]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the box that is shown: the labelled points and some room, or all without any."""
    shown = places[what != Difference.UNLABELLED] if what.any() else places
    if not len(shown):
        return np.zeros(2), np.ones(2)
    low, high = np.percentile(shown, [OUTLIERS, 100 - OUTLIERS], axis=0)
    room = max(0.1, MARGIN * float((high - low).max()))
    return low - room, high + room


def _dots(
    canvas: NDArray[np.uint8], pixels: NDArray[np.int64], color: tuple[int, int, int], size: int
) -> None:
    height, width, _ = canvas.shape
    for right in range(size):
        for down in range(size):
            x, y = pixels[:, 0] + right, pixels[:, 1] + down
            inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
            canvas[y[inside], x[inside]] = color
