"""Pieces of a frame whose answer would teach most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.features import Described
from pointbrush.classify.options import DoubtOptions
from pointbrush.classify.smoothing import Chances, decided

Floats = NDArray[np.float64]
MOST_COMPARED = 400
"""Examples that a piece is compared with."""


@dataclass(frozen=True, slots=True, eq=False)
class Doubt:
    """A piece: ``centre`` (3,) metres, on the surface; its ``points``; the two classes that it may
    be, the likelier first; ``doubt`` 0 to 1; ``worth`` by which pieces are compared."""

    centre: Floats
    points: int
    classes: tuple[int, int]
    doubt: float
    worth: float


def doubts(
    place: Described,
    chance: Chances,
    answered: NDArray[np.bool_],
    taught: NDArray[np.float32],
    spread: Floats,
    options: DoubtOptions,
    most: int = 1,
) -> list[Doubt]:
    """Return at most ``most`` pieces, the one that would teach most first.

    ``answered`` (C,): cells that people have labelled; ``taught`` (n, F): what was learnt from.
    """
    options.check()
    best, margin = decided(chance)
    open_ = np.flatnonzero(~answered)
    if not len(open_):
        return []
    cube = np.floor(place.center[open_] / (options.edge * place.size)).astype(np.int64)
    keys = np.column_stack([cube, best[open_]])
    piece = np.unique(keys, axis=0, return_inverse=True)[1].ravel()
    unsure = (1.0 - margin[open_].astype(np.float64)) ** 2
    weight = np.asarray(np.bincount(piece, unsure), np.float64)
    held = np.bincount(piece)
    weight[held < options.fewest] *= 1e-6
    order = np.argsort(-weight, kind="stable")[: options.considered]
    points = np.bincount(place.of_point, minlength=len(answered))
    found = []
    chosen: list[Floats] = []
    novel = _Novelty(taught, spread)
    about = [_about(place, open_[piece == each], unsure[piece == each]) for each in order]
    worth = np.array([weight[each] for each in order])
    away = np.array([novel.of(features) for _, features in about])
    for _ in range(min(most, len(order))):
        rated = worth * away
        at = int(rated.argmax())
        cell, features = about[at]
        members = open_[piece == order[at]]
        found.append(
            Doubt(
                place.center[cell].astype(np.float64), int(points[members].sum()),
                _two(chance[cell]), float(1.0 - margin[members].mean()), float(rated[at]),
            )
        )  # fmt: skip
        chosen.append(features)
        worth[at] = -1.0
        away = np.minimum(away, [novel.between(features, other) for _, other in about])
    return found


def _about(place: Described, cells: NDArray[np.int64], unsure: Floats) -> tuple[int, Floats]:
    """Choose the cell of a piece that is nearest to the middle of its doubt, and its features."""
    share = unsure / max(float(unsure.sum()), 1e-12)
    middle = share @ place.center[cells].astype(np.float64)
    away = np.linalg.norm(place.center[cells] - middle, axis=1)
    at = int(cells[(away / place.size - 2.0 * unsure).argmin()])
    return at, place.features[at].astype(np.float64)


def _two(chance: NDArray[np.float32]) -> tuple[int, int]:
    order = np.argsort(-chance, kind="stable")
    return int(order[0]), int(order[min(1, len(order) - 1)])


class _Novelty:
    """Compares pieces with examples: 0 alike, 1 unlike."""

    def __init__(self, taught: NDArray[np.float32], spread: Floats) -> None:
        step = -(-len(taught) // MOST_COMPARED) if len(taught) else 1
        self._scale = np.where(spread > 0, spread, 1.0)
        self._taught = taught[::step] / self._scale

    def of(self, features: Floats) -> float:
        """Compare with the nearest example."""
        if not len(self._taught):
            return 1.0
        apart = np.minimum(np.abs(self._taught - features / self._scale), 1.0)
        return float(apart.mean(axis=1).min())

    def between(self, one: Floats, other: Floats) -> float:
        """Compare two pieces."""
        return float(np.minimum(np.abs(one - other) / self._scale, 1.0).mean())
