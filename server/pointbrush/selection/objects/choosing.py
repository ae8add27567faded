"""Clicks on a prepared frame → at most six nested candidates, from part to group.

All regions that clicks can mean are proposed; of those that the value model expects to be right
the few are offered that clearly differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.objects import sums
from pointbrush.selection.objects.clicks import (
    Clicks,
    Taken,
    kept_cells,
    place_clicks,
    taken_so_far,
)
from pointbrush.selection.objects.options import LadderOptions, ObjectOptions
from pointbrush.selection.objects.state import ObjectState
from pointbrush.selection.objects.unions import Origin, Unions, find_unions
from pointbrush.selection.objects.value import REGION, expected_iou, value_features
from pointbrush.selection.objects.weights import Forest, Weights, built_in

Mask = NDArray[np.bool_]
NOWHERE = np.empty((0, 3))


class Scored(NamedTuple):
    """``masks`` (n, P) of pieces, ``cells`` (P,) of each piece, and their ``score`` (n,).

    ``alone`` (n,): given by the clicks alone, without an earlier selection.
    """

    masks: Mask
    cells: NDArray[np.float64]
    score: NDArray[np.float64]
    alone: Mask


def choose_levels(
    found: Scored, kept: int | None, margin: float, options: LadderOptions, flat: Sequence[int] = ()
) -> list[int]:
    """Choose nested candidates: the one to show, then the others by falling score.

    ``kept``: number of the earlier selection, which stays among them, and first unless another is
    better by ``margin``; the best of the others that the clicks alone give is offered beside it,
    nested or not.  ``flat``: whole floors, walls or table tops, offered in the same way while
    nothing is taken, if they differ.
    """
    masks, cells, score, alone = found
    size = masks.astype(np.float64) @ cells
    order = np.argsort(-score, kind="stable").tolist()
    if kept is None:
        chain = _chain(masks, size, [order[0], *flat[:1], *order], options.closest, options.levels)
        for other in flat:
            both = (masks[chain] & masks[other]) @ cells
            if (both < options.closest_flat * (size[chain] + size[other] - both)).all():
                chain = _with_candidate(chain[: options.levels - 1], other)
        return chain
    # Both stay in reach, whichever is first: what was taken, mended, and the best in its place.
    uncovered = next((i for i in order if i != kept and alone[i]), kept)
    better = score[order[0]] > score[kept] + margin
    first, other = (order[0], kept) if better else (kept, uncovered)
    chain = _chain(masks, size, [first, *order], options.closest_after, options.levels - 1)
    return _with_candidate(chain, other)


def _with_candidate(chain: list[int], other: int) -> list[int]:
    """The same with another candidate after the first one, unless it is among them."""
    return chain if other in chain else [chain[0], other, *chain[1:]]


def _chain(
    masks: Mask, size: NDArray[np.float64], order: list[int], closest: float, most: int
) -> list[int]:
    """The first candidate and those after it that hold, or lie in, all that were chosen before."""
    chosen: list[int] = []
    for i in order:
        if len(chosen) == most:
            break
        if all(_is_clearly_larger(masks, size, i, other, closest) for other in chosen):
            chosen.append(i)
    return chosen


def _is_clearly_larger(
    masks: Mask, size: NDArray[np.float64], i: int, other: int, closest: float
) -> bool:
    """Whether one of two candidates holds the other and is clearly larger."""
    small, large = (i, other) if size[i] < size[other] else (other, i)
    if size[small] > closest * size[large]:
        return False
    return not bool((masks[small] & ~masks[large]).any())


@dataclass(frozen=True, slots=True, eq=False)
class Proposals:
    """``unions`` of pieces and their ``features`` (n, VALUES); with something ``taken`` the last
    is that.  ``open_`` (C,) cells that are not nearer to an unwanted click on the same piece."""

    unions: Unions
    features: NDArray[np.float64]
    taken: Taken | None
    open_: Mask

    def points(self, state: ObjectState, chosen: list[int]) -> list[NDArray[np.int64]]:
        """Return the point numbers of some proposals, at most eight, ascending.

        Of what is taken only the pieces change that a proposal adds or leaves out as a whole.
        """
        kept = added = self.unions.masks[chosen]
        if self.taken is not None:
            kept, added = kept | ~self.taken.pieces, added & ~self.taken.pieces
        # Each proposal is a bit, so that one pass over cells and points is enough for all.
        cells = np.where(self.open_, _bits(added)[state.piece], 0)
        if self.taken is not None:
            cells |= np.where(self.taken.cells, _bits(kept)[state.piece], 0)
        points = np.append(cells, np.uint8(0))[state.of_point]  # the last one: without a cell
        return [np.flatnonzero(points & (1 << bit) != 0) for bit in range(len(chosen))]


def _bits(masks: Mask) -> NDArray[np.uint8]:
    """Pack masks (n, P), at most eight, into a number for each piece (P,)."""
    return np.asarray(np.packbits(masks, axis=0, bitorder="little")[0], np.uint8)


def propose(
    state: ObjectState,
    wanted: Clicks,
    unwanted: Clicks,
    mask: NDArray[np.integer] | Mask | None,
    model: Forest,
    options: ObjectOptions,
) -> Proposals:
    """Return all regions for some clicks; ``model`` is the merge model.

    Raises BadInputError for a mask out of range.
    """
    taken = taken_so_far(state, mask, wanted, unwanted, options.clicks)
    unions = find_unions(state, wanted, unwanted, taken, model, options.ladder)
    pieces = None if taken is None else taken.pieces
    features = value_features(state, unions, wanted, unwanted, pieces)
    return Proposals(unions, features, taken, kept_cells(state, wanted, unwanted))


def _widened(
    found: Proposals, cells: NDArray[np.float64], first: int, flat: int, spill: float
) -> Proposals:
    """Return proposals in which a plane has the few pieces of the first beside it: both nest.

    ``cells`` (P,) of each piece.
    """
    masks = found.unions.masks
    beside = masks[first] & ~masks[flat]
    if cells[beside].sum() > spill * cells[masks[flat]].sum():
        return found
    wider = masks.copy()
    wider[flat] |= beside
    return replace(found, unions=replace(found.unions, masks=wider))


def _likely_right(found: Proposals, options: LadderOptions) -> bool:
    """Whether contradicting clicks lie near the border of what is taken."""
    spread = found.features[-1, REGION + 4]
    return found.taken is not None and found.taken.far <= options.sure_far * spread


def _calibrated(
    score: NDArray[np.float64], shown: float, options: LadderOptions
) -> NDArray[np.float64]:
    """Raise the scores from that of the level ``shown`` first on: real objects fit it better.

    The order of the scores stays.
    """
    raised = _chance(options.camera_odds + options.camera_slope * _odds(score))
    return np.asarray(np.where(score >= shown, np.maximum(score, raised), score))


def _odds(score: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return log odds, of chances of 0.02 to 0.98."""
    return np.asarray(np.log(np.clip(score, 0.02, 0.98) / np.clip(1 - score, 0.02, 0.98)))


def _chance(odds: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(1 / (1 + np.exp(-odds)))


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
    first = mask is None or np.size(mask) == 0
    wanted = place_clicks(state, positives, "positives", options.clicks, first)
    unwanted = place_clicks(state, negatives, "negatives", options.clicks, first)
    if len(wanted) == 0:
        return []
    model = weights or built_in(state.sensor)
    found = propose(state, wanted, unwanted, mask, model.merge, options)
    score = expected_iou(found.features, model.value)
    cells = state.sums[: state.piece_count, sums.COUNT]
    kept = None if found.taken is None else len(score) - 1
    alone = np.isin(found.unions.origin, (Origin.TREE, Origin.GROWN))
    ladder = options.ladder
    sure = _likely_right(found, ladder)
    if sure and found.taken is not None:
        found = replace(found, taken=replace(found.taken, cells=found.taken.least))
    lidar_keep = ladder.sure_keep if sure else ladder.keep
    margins = {"room": ladder.room_keep, "camera": ladder.camera_keep, "lidar": lidar_keep}
    flat = np.flatnonzero(found.unions.origin == Origin.PLANE).tolist() if kept is None else []
    if flat:
        area = (found.unions.masks[flat] @ cells).min() * state.size**2
        odds = ladder.flat_slope * np.log(area / ladder.flat_area)
        likely = int(np.where(alone, score, 0).argmax())
        score[flat[0]] = max(score[flat[0]], _chance(np.minimum(odds, ladder.flat_most)))
    for each in flat:
        found = _widened(found, cells, likely, each, ladder.spill)
    masks = found.unions.masks
    scored = Scored(masks, cells, score, alone)
    chosen = choose_levels(scored, kept, margins[state.sensor], ladder, flat)
    if state.sensor == "camera" and not flat:
        score = _calibrated(score, float(score[chosen[0]]), ladder)
    if state.sensor == "lidar":
        size_odds = ladder.lidar_odds * np.log(cells[masks[chosen[0]]].sum() / ladder.lidar_cells)
        score = _chance(_odds(score) + size_odds)
    points = found.points(state, chosen)
    level = np.argsort(np.argsort([len(each) for each in points], kind="stable"), kind="stable")
    return [
        Candidate(indices, float(score[i]), int(place))
        for indices, i, place in zip(points, chosen, level, strict=True)
    ]
