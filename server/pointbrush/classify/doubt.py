"""Most informative places of a frame for an answer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.features import Described
from pointbrush.classify.options import DoubtOptions
from pointbrush.classify.smoothing import Chances, likeliest_classes

Floats = NDArray[np.float32]
Cells = NDArray[np.int64]
MOST_COMPARED = 400
"""Examples that a place is compared with."""
AT_ONCE = 64
"""Rows compared at once, so that the differences stay in the processor's cache."""
UNSURE = 0.25
"""Confidence below which a cell is in doubt."""
RAREST = 0.002
"""Least share of a class that counts, of the cells of a frame."""


@dataclass(frozen=True, slots=True)
class Doubt:
    """A ``cell`` to ask about; the two ``classes`` that it may be, the likelier first; ``doubt``
    0 to 1; ``worth`` by which places are compared, also of other frames."""

    cell: int
    classes: tuple[int, int]
    doubt: float
    worth: float


def doubts(
    place: Described,
    chance: Chances,
    open_: NDArray[np.bool_],
    taught: Floats,
    spread: NDArray[np.float64],
    options: DoubtOptions,
    most: int = 1,
) -> list[Doubt]:
    """Return at most ``most`` places, most informative first.

    A place is informative if many doubtful points, of rare classes, resemble it more than any
    example.  ``open_`` (C,): cells that may be asked about; ``taught`` (n, F): features that
    were learnt from.
    """
    points = np.flatnonzero(open_[place.of_point])
    if not len(points):
        return []
    cells = place.of_point[_some(points, options.compared)]
    margin = likeliest_classes(chance)[1].astype(np.float64)
    best = two_best(chance)
    unsure = (1.0 - margin[cells]) * _rarity(best[cells], chance.shape[1], options)
    scale = np.where(spread > 0, spread, 1.0).astype(np.float32)
    features = place.features[cells] / scale
    reached = np.cumsum(unsure)
    considered = reached.searchsorted(np.linspace(0, reached[-1], options.considered))
    considered = considered[np.unique(cells[considered], return_index=True)[1]]
    apart = _dissimilarity(features[considered], features)
    examples = _some(np.arange(len(taught)), MOST_COMPARED)
    nearest = np.ones(len(cells), np.float32)
    if len(examples):
        nearest = _dissimilarity(features, taught[examples] / scale).min(axis=1)
    share = len(points) / len(cells)
    found = []
    for _ in range(min(most, len(considered))):
        worth = np.maximum(nearest - apart, 0.0) @ unsure
        at = int(worth.argmax())
        cell = int(cells[considered[at]])
        found.append(
            Doubt(
                cell,
                (int(best[cell, 0]), int(best[cell, 1])),
                float(1.0 - margin[cell]),
                share * float(worth[at]),
            )
        )
        nearest = np.minimum(nearest, apart[at])
    return found


def _some(numbers: Cells, most: int) -> Cells:
    """Choose at most ``most`` numbers, evenly."""
    if len(numbers) <= most:
        return numbers
    return np.asarray(numbers[np.linspace(0, len(numbers) - 1, most).astype(np.int64)])


def _rarity(best: Cells, kinds: int, options: DoubtOptions) -> NDArray[np.float64]:
    """Return weights (C,) of cells, larger for rarer classes among their two ``best`` (C, 2)."""
    share = np.bincount(best[:, 0], minlength=kinds) / len(best)
    weight = np.maximum(share, RAREST) ** -options.rarity
    return np.asarray(weight[best].max(axis=1), np.float64)


def _dissimilarity(one: Floats, other: Floats) -> Floats:
    """Compare features (n, F) and (m, F): (n, m), 0 alike, 1 unlike."""
    out = np.empty((len(one), len(other)), np.float32)
    for at in range(0, len(one), AT_ONCE):
        rows = one[at : at + AT_ONCE, None]
        out[at : at + AT_ONCE] = np.minimum(np.abs(rows - other), 1.0).mean(axis=2)
    return out


def two_best(chance: Chances) -> Cells:
    """Return the two most probable classes (C, 2) of each cell, the same twice if there is one."""
    order = np.argsort(-chance, axis=1, kind="stable")
    return order[:, [0, min(1, chance.shape[1] - 1)]]


def confusions(
    place: Described, chance: Chances, open_: NDArray[np.bool_], options: DoubtOptions
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the points (K, K) in doubt between two classes, the first one lower, and the number
    (K,) of places in doubt of each class."""
    kinds = chance.shape[1]
    best, margin = likeliest_classes(chance)
    cells = np.flatnonzero(open_ & (margin < UNSURE))
    order = np.sort(two_best(chance[cells]), axis=1)
    held = np.bincount(place.of_point, minlength=len(chance))[cells]
    pairs = np.bincount(order[:, 0] * kinds + order[:, 1], held, kinds * kinds)
    cubes = np.floor(place.center[cells] / (options.edge * place.size)).astype(np.int64)
    places = np.unique(np.column_stack([cubes, best[cells]]), axis=0)
    left = np.bincount(places[:, 3], minlength=kinds)
    return pairs.astype(np.int64).reshape(kinds, kinds), left
