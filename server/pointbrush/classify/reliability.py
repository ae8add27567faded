"""Reliability of a classifier: how far trees that did not learn from the same places agree."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.forest import GROUPS, Trees, groups_of, learn, probabilities
from pointbrush.classify.options import ForestOptions
from pointbrush.classify.smoothing import Chances, likeliest_classes
from pointbrush.values.classifiers import HeldOut

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
FEWEST_PLACES = 3
"""Painted places of a class below which its accuracy is not measured."""
RELIABLE = 0.9
"""Expected accuracy of the points that are labelled by default."""
START_PLACES = 5.0
"""Local places of a class that weigh as much as all its examples of earlier work."""
DEFAULT_ABOVE = 0.5
"""Confidence from which on points are labelled by default, before it is measured."""


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
            own, earlier = (
                np.flatnonzero((self.classes == kind) & (self.own == o)) for o in (1, 0)
            )
            places = len(np.unique(self.place[own]))
            out[own] = places / (places + START_PLACES) / max(len(own), 1)
            out[earlier] = START_PLACES / (places + START_PLACES) / len(earlier)
        return out

    def learnt(self, count: int, spread: Floats, options: ForestOptions) -> Trees:
        """Return trees that know ``count`` classes."""
        shares, folds = self.shares(), self.folds()
        return learn(self.features, self.classes, count, spread, options, shares, folds)

    def folds(self) -> Ints:
        """Deal places into folds (n,), each class alike; -1: the only place of a class."""
        names, first, where = np.unique(self.place, return_index=True, return_inverse=True)
        fold = np.empty(len(names), np.int64)
        fold[np.lexsort((names, self.classes[first]))] = np.arange(len(names)) % GROUPS
        out = fold[where.ravel()]
        for kind in np.unique(self.classes):
            members = self.classes == kind
            if len(np.unique(out[members])) == 1:
                out[members] = -1
        return out


class Reliability(NamedTuple):
    """Expected accuracy in the taught frames, of all points and by class; None if not measured.

    ``above``: the confidence from which on points are ``RELIABLE``.
    """

    score: float | None
    held_out: tuple[HeldOut, ...]
    above: float


def reliability(
    taught: Taught, trees: Trees, features: NDArray[np.float32], chance: Chances
) -> Reliability:
    """Expect the accuracy in frames; ``features`` (n, F) and ``chance`` (n, K) are a sample.

    Each group of trees left out a part of the painted places.  The share of groups that agree
    with the prediction is about the probability that it is correct.  The accuracy in held-out
    places is lower, because people paint where predictions are wrong.
    """
    painted = [
        len(np.unique(taught.place[taught.own & (taught.classes == kind)]))
        for kind in range(chance.shape[1])
    ]
    measured = sum(number >= FEWEST_PLACES for number in painted)
    if measured < min(2, len(painted)) or not len(chance):
        unknown = tuple(HeldOut(None, number) for number in painted)
        return Reliability(None, unknown, DEFAULT_ABOVE)
    best, margin = likeliest_classes(chance)
    votes = [probabilities(group, features).argmax(axis=1) == best for group in groups_of(trees)]
    agree = np.mean(votes, axis=0)
    found = []
    for kind, number in enumerate(painted):
        cells = agree[best == kind]
        known = number >= FEWEST_PLACES and len(cells) > 0
        found.append(HeldOut(float(cells.mean()) if known else None, number))
    return Reliability(float(agree.mean()), tuple(found), _above(margin, agree))


def _above(margin: NDArray[np.float32], expected: Floats) -> float:
    """Return the lowest confidence at which points are expected to be reliable."""
    order = np.argsort(-margin, kind="stable")
    mean = np.cumsum(expected[order]) / np.arange(1, len(order) + 1)
    enough = np.flatnonzero(mean >= RELIABLE)
    return float(margin[order[enough[-1]]]) if len(enough) else DEFAULT_ABOVE
