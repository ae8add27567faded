"""Colours of reviewed points: the recording's own under the labels'."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import Label

PLAIN = 160
"""Grey of points without colour of their own."""


def lookup(palette: Iterable[Label]) -> NDArray[np.uint8]:
    """Label colours (65536, 3) by label id."""
    table = np.full((65_536, 3), PLAIN, np.uint8)
    for label in palette:
        table[label.id] = tuple(bytes.fromhex(label.color[1:]))
    return table


def blend(
    rgb: NDArray[np.uint8] | None,
    label: NDArray[np.uint16],
    colors: NDArray[np.uint8],
    share: float,
) -> NDArray[np.uint8]:
    """Colours (N, 3): ``share`` 0..1 of the label's colour on labelled points (N,)."""
    base = np.full((len(label), 3), PLAIN, np.uint8) if rgb is None else rgb.copy()
    labeled = label > 0
    mixed = (1 - share) * base[labeled] + share * colors[label[labeled]]
    base[labeled] = np.round(mixed).astype(np.uint8)
    return base
