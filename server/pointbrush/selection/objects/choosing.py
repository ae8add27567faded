"""Clicks on a prepared frame → at most six nested candidates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.objects import sums
from pointbrush.selection.objects.clicks import place_clicks
from pointbrush.selection.objects.ladder import choose_levels
from pointbrush.selection.objects.options import ObjectOptions
from pointbrush.selection.objects.proposals import Mask, propose
from pointbrush.selection.objects.state import ObjectState
from pointbrush.selection.objects.value import expected_iou
from pointbrush.selection.objects.weights import Weights, built_in

NOWHERE = np.empty((0, 3))


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """``indices`` (n,) int64 points, ascending, stored order; ``score`` 0..1 the IoU to expect;
    ``level`` 0 for the smallest one offered."""

    indices: NDArray[np.int64]
    score: float
    level: int


def candidates(
    state: ObjectState,
    positives: NDArray[np.floating],
    negatives: NDArray[np.floating] = NOWHERE,
    mask: NDArray[np.integer] | Mask | None = None,
    options: ObjectOptions | None = None,
    weights: Weights | None = None,
) -> list[Candidate]:
    """Return nested candidates that hold every positive click and no negative one.

    ``positives`` (K, 3) and ``negatives`` (L, 3) local metres, each taken at the cell nearest to
    it; ``mask`` the points taken so far, as numbers or (N,) bool: it is then offered again with no
    more than the new clicks ask for, unless it is empty.  The first candidate is the one to show;
    ``level`` orders them by size.  Without a positive click or without points: none.
    Raises BadInputError for clicks that are not finite and for a mask out of range.
    """
    options = options or ObjectOptions()
    wanted = place_clicks(state, positives, "positives")
    unwanted = place_clicks(state, negatives, "negatives")
    if len(wanted) == 0:
        return []
    found = propose(state, wanted, unwanted, mask, options)
    score = expected_iou(found.features, (weights or built_in()).value)
    size = found.unions.masks.astype(np.float64) @ state.sums[: state.piece_count, sums.COUNT]
    kept = None if found.taken is None else len(size) - 1
    chosen = choose_levels(found.unions.masks, size, score, kept, options.ladder)
    points = [found.points(state, i) for i in chosen]
    level = np.argsort(np.argsort([len(each) for each in points], kind="stable"), kind="stable")
    return [
        Candidate(indices, float(score[i]), int(place))
        for indices, i, place in zip(points, chosen, level, strict=True)
    ]
