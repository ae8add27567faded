"""Reliability of a classifier, measured in painted places that are held out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.forest import Trees, learn, probabilities
from pointbrush.classify.options import ForestOptions
from pointbrush.classify.smoothing import decided

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
FOLDS = 10
FEWEST_PLACES = 3
"""Painted places of a class below which its accuracy is not measured."""
RELIABLE = 0.9
"""Expected accuracy of the points that are labelled by default."""
START_PLACES = 5.0
"""Local places of a class that weigh as much as all its examples of earlier work."""
DEFAULT_ABOVE = 0.5
"""Confidence from which on points are labelled by default, before it is measured."""
PRIOR_PLACES = 4.0
"""Held-out places of a class that weigh as much as the reliability of all classes."""


class Taught(NamedTuple):
    """Examples: ``features`` (n, F), ``classes`` (n,), ``place`` (n,) and whether they are ``own``,
    not of earlier work (n,)."""

    features: NDArray[np.float32]
    classes: Ints
    place: Ints
    own: NDArray[np.bool_]

    def shares(self) -> Floats:
        """Return the weight (n,) of each example beside others of its class.

        Examples of earlier work weigh the less, the more places of their class are painted here.
        """
        out = np.ones(len(self.classes))
        for kind in np.unique(self.classes[~self.own]):
            here, there = (np.flatnonzero((self.classes == kind) & (self.own == o)) for o in (1, 0))
            places = len(np.unique(self.place[here]))
            out[here] = places / (places + START_PLACES) / max(len(here), 1)
            out[there] = START_PLACES / (places + START_PLACES) / len(there)
        return out

    def learnt(self, count: int, spread: Floats, options: ForestOptions) -> Trees:
        """Return trees that know ``count`` classes."""
        return learn(self.features, self.classes, count, spread, options, self.shares())


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Expected ``accuracy`` of a class, 0 to 1, None before enough ``places`` are painted."""

    accuracy: float | None
    places: int


class Reliability(NamedTuple):
    """Expected accuracy in the taught frames, of all points and by class; None if not measured.

    ``above``: the confidence from which on points are ``RELIABLE``.
    """

    score: float | None
    held_out: tuple[HeldOut, ...]
    above: float


def reliability(
    taught: Taught, count: int, spread: Floats, options: ForestOptions, best: Ints, margin: Floats
) -> Reliability:
    """Measure the accuracy in held-out places, and expect it in frames.

    ``best`` (N,) and ``margin`` (N,) are the predicted classes and confidences of the frames'
    points.  People paint where predictions are wrong.  Therefore the held-out places do not
    represent the frame; the accuracy at each confidence does (isotonic regression).
    """
    from scipy.optimize import isotonic_regression  # loads much that no other call needs

    own = np.flatnonzero(taught.own)
    kinds, places = taught.classes[own], taught.place[own]
    painted = [len(np.unique(places[kinds == kind])) for kind in range(count)]
    measured = [number >= FEWEST_PLACES for number in painted]
    unknown = tuple(HeldOut(None, number) for number in painted)
    if sum(measured) < min(2, count):
        return Reliability(None, unknown, DEFAULT_ABOVE)
    guess, sure = _held_out(taught, count, spread, options)
    right = (guess == kinds).astype(np.float64)
    _, where, size = np.unique(places, return_inverse=True, return_counts=True)
    weight = 1.0 / size[where.ravel()]
    order = np.argsort(sure, kind="stable")
    curve = isotonic_regression(right[order], weights=weight[order]).x
    expected = np.interp(margin, sure[order], curve)
    beyond = right - np.interp(sure, sure[order], curve)
    found, total, share = [], 0.0, 0.0
    for kind in range(count):
        told, cells = guess == kind, best == kind
        offset = (weight * beyond)[told].sum() / (weight[told].sum() + PRIOR_PLACES)
        accuracy = None
        if measured[kind]:
            mean = float(expected[cells].mean()) if cells.any() else float(right[told].mean())
            accuracy = float(np.clip(mean + offset, 0, 1))
            total, share = total + accuracy * cells.mean(), share + cells.mean()
        found.append(HeldOut(accuracy, painted[kind]))
    return Reliability(total / share if share else None, tuple(found), _above(margin, expected))


def _held_out(
    taught: Taught, count: int, spread: Floats, options: ForestOptions
) -> tuple[Ints, Floats]:
    """Predict own examples (n,) by trees that were not taught their places; also the confidence."""
    own = np.flatnonzero(taught.own)
    names, first, where = np.unique(taught.place[own], return_index=True, return_inverse=True)
    fold = np.empty(len(names), np.int64)
    fold[np.lexsort((names, taught.classes[own[first]]))] = np.arange(len(names)) % FOLDS
    out = fold[where.ravel()]
    best, margin = np.zeros(len(own), np.int64), np.zeros(len(own))
    fewer = replace(options, trees=max(1, options.trees // 3))
    for number in range(FOLDS):
        held = own[out == number]
        kept = np.setdiff1d(np.arange(len(taught.classes)), held)
        if len(held) and len(kept):
            rest = Taught(*(column[kept] for column in taught))
            trees = rest.learnt(count, spread, fewer)
            chance = probabilities(trees, taught.features[held])
            best[out == number], margin[out == number] = decided(chance)
    return best, margin


def _above(margin: Floats, expected: Floats) -> float:
    """Return the lowest confidence at which points are expected to be reliable."""
    order = np.argsort(-margin, kind="stable")
    mean = np.cumsum(expected[order]) / np.arange(1, len(order) + 1)
    enough = np.flatnonzero(mean >= RELIABLE)
    return float(margin[order[enough[-1]]]) if len(enough) else DEFAULT_ABOVE
