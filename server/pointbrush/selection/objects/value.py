"""Features of a candidate for the value model, and the expected IoU."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled, innermost
from pointbrush.selection.objects import sums
from pointbrush.selection.objects.clicks import Clicks
from pointbrush.selection.objects.state import ObjectState
from pointbrush.selection.objects.unions import Origin, Unions
from pointbrush.selection.objects.weights import Forest, answer

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
VALUES = 60
"""Number of features of a candidate."""
REGION, CUT, CLICKS, HISTORY, STEPS, SUPPORT = 0, 23, 31, 39, 45, 54
LEVEL = 0.9
"""Minimum mean |nz| of a level piece."""
BOTTOM = 0.2
"""Share of a region's height that counts as its bottom."""
FAR = 1e3
"""Metres; placeholder for no such cell."""


def value_features(
    state: ObjectState, unions: Unions, wanted: Clicks, unwanted: Clicks, mask: Mask | None
) -> Floats:
    """Return the features (n, VALUES) of candidates, in the order of ``unions``."""
    pieces = state.piece_count
    leaves, masks = state.sums[:pieces], unions.masks
    out = np.zeros((len(masks), VALUES))
    total = np.empty((len(masks), sums.WIDTH))
    total[:, : sums.ADDED] = masks.astype(np.float64) @ leaves[:, : sums.ADDED]
    _bounds(masks, leaves, total)
    cut = _cut(masks, state.pairs, state.between, state.first)
    _regions(total, cut, state.size**2, out)
    out[:, CLICKS : CLICKS + 4] = _reach(masks, wanted)
    out[:, CLICKS + 4] = np.minimum(_nearest(masks, unwanted), FAR)
    out[:, CLICKS + 5], out[:, CLICKS + 6] = len(wanted), len(unwanted)
    out[:, CLICKS + 7] = out[:, CLICKS] / np.maximum(out[:, CLICKS + 3], 1e-3)
    _history(leaves[:, sums.COUNT], unions, mask, out[:, HISTORY:STEPS])
    # Grown regions and planes form separate sequences, with steps within each of them.
    grown, flat = unions.origin == Origin.GROWN, unions.origin == Origin.PLANE
    for part in (np.flatnonzero(~grown & ~flat), np.flatnonzero(grown), np.flatnonzero(flat)):
        if len(part):
            size, reach = total[part, sums.COUNT], out[part, REGION + 4]
            out[part, STEPS:SUPPORT] = _steps(size, reach, unions.made[part], unions.ended[part])
    clicked = np.zeros(pieces, np.bool_)
    clicked[wanted.piece] = True
    _support(masks, clicked, state.pairs, state.between, leaves, total, out[:, SUPPORT:])
    return out


@compiled
def values(features: Floats, model: Forest) -> Floats:
    """Return the expected IoU (n,) of candidates by their features (n, VALUES)."""
    result = np.empty(len(features))
    for i in range(len(features)):
        result[i] = answer(model, features[i])
    return result


def expected_iou(features: Floats, model: Forest) -> Floats:
    """Return the expected IoU (n,), 0 to 1."""
    return np.asarray(np.clip(values(features, model), 0.0, 1.0))


@compiled
def _bounds(masks: Mask, leaves: Floats, total: Floats) -> None:
    for i in range(len(masks)):
        for k in range(3):
            total[i, sums.LOW + k], total[i, sums.HIGH + k] = np.inf, -np.inf
        for p in range(masks.shape[1]):
            if masks[i, p]:
                for k in range(3):
                    low, high = sums.LOW + k, sums.HIGH + k
                    total[i, low] = min(total[i, low], leaves[p, low])
                    total[i, high] = max(total[i, high], leaves[p, high])


@compiled
def _cut(
    masks: Mask, pairs: NDArray[np.int32], between: NDArray[np.float32], odds: NDArray[np.float32]
) -> Floats:
    """Return sums (n, 9) over the boundary.

    They are the six sums of a pair, edges times probability, the maximum probability, and the mean
    probability inside.
    """
    out = np.zeros((len(masks), 9))
    chance = 1.0 / (1.0 + np.exp(-odds.astype(np.float64)))
    for i in range(len(masks)):
        inner = edges = 0.0
        for b in range(len(pairs)):
            one, other = masks[i, pairs[b, 0]], masks[i, pairs[b, 1]]
            if one and other:
                inner += between[b, 0] * chance[b]
                edges += between[b, 0]
            elif one or other:
                for k in range(6):
                    out[i, k] += between[b, k]
                out[i, 6] += between[b, 0] * chance[b]
                out[i, 7] = max(out[i, 7], chance[b])
        out[i, 8] = inner / edges if edges > 0 else 1.0
    return out


@compiled
def _support(
    masks: Mask,
    clicked: Mask,
    pairs: NDArray[np.int32],
    between: NDArray[np.float32],
    leaves: Floats,
    total: Floats,
    out: Floats,
) -> None:
    """Write features that separate an object from its support to ``out`` (n, 6).

    They are shares of the region: clicked pieces, the largest piece, level pieces at its bottom;
    and over its boundary: the share of level pieces below it, the levelness of the outside, and its
    height difference in metres.
    """
    z = sums.XYZ + 2
    for i in range(len(masks)):
        count = max(total[i, sums.COUNT], 1.0)
        low = total[i, sums.LOW + 2]
        bottom = low + BOTTOM * (total[i, sums.HIGH + 2] - low)
        for p in range(len(leaves)):
            if masks[i, p]:
                n = leaves[p, sums.COUNT]
                out[i, 0] += n / count * clicked[p]
                out[i, 1] = max(out[i, 1], n / count)
                if leaves[p, sums.STEEP] >= LEVEL * n and leaves[p, z] <= bottom * n:
                    out[i, 2] += n / count
        edges = 0.0
        for b in range(len(pairs)):
            one, other = pairs[b, 0], pairs[b, 1]
            if masks[i, one] == masks[i, other]:
                continue
            inner, outer = (one, other) if masks[i, one] else (other, one)
            m, n = between[b, 0], leaves[outer, sums.COUNT]
            step = leaves[outer, z] / n - leaves[inner, z] / leaves[inner, sums.COUNT]
            steep = leaves[outer, sums.STEEP] / n
            edges += m
            out[i, 3] += m * (steep >= LEVEL and step < 0)
            out[i, 4] += m * steep
            out[i, 5] += m * step
        for k in range(3, 6):
            out[i, k] /= max(edges, 1.0)


@compiled
def _regions(total: Floats, cut: Floats, area: float, out: Floats) -> None:
    for i in range(len(total)):
        _region(total[i], cut[i], area, out[i])


@innermost
def _region(row: Floats, cut: Floats, area: float, out: Floats) -> None:
    n, at = row[sums.COUNT], REGION
    out[at], out[at + 1] = np.log(n), np.log(n * area)
    sums.extents(row, out[at + 2 : at + 5])
    low, middle, high = out[at + 2], out[at + 3], out[at + 4]
    out[at + 5] = low / max(high, 1e-6)
    out[at + 6] = middle / max(high, 1e-6)
    out[at + 7] = sums.colour_spread(row)
    out[at + 8], out[at + 9] = row[sums.ROUGH] / n, row[sums.STEEP] / n
    out[at + 10] = sums.normal_length(row)
    sums.box(row, out[at + 11 : at + 14])
    out[at + 14], out[at + 15] = row[sums.LOW + 2], row[sums.HIGH + 2]
    out[at + 16] = row[sums.XYZ + 2] / n
    # Filled shares of the upright box, and of a region's own extent.
    out[at + 17] = np.log(n * area / max(out[at + 12] * (out[at + 11] + out[at + 13]), 1e-6))
    out[at + 18] = np.log(n * area / max(high * middle, 1e-6))
    variance = 0.0
    for k in range(3):
        mean = row[sums.LAB + k] / n
        out[at + 19 + k] = np.sqrt(max(row[sums.LAB_SQUARES + k] / n - mean * mean, 0.0))
        variance += out[at + 19 + k]
    out[at + 22] = variance
    at, edges = CUT, max(cut[0], 1.0)
    out[at], out[at + 1] = cut[0] / np.sqrt(n), cut[0] / n
    for k in range(4):
        out[at + 2 + k] = cut[1 + k] / edges
    out[at + 6] = cut[6] / edges
    out[at + 7] = cut[7] - cut[8]


@compiled
def _reach_loop(masks: Mask, nearest: Floats, farthest: Floats) -> Floats:
    """Return distances (n, 4) of clicks: minimum and mean to the nearest cell outside, mean and
    maximum to the farthest cell inside."""
    out = np.zeros((len(masks), 4))
    clicks = len(nearest)
    for i in range(len(masks)):
        out[i, 0] = np.inf
        for k in range(clicks):
            outside, inside = FAR, 0.0
            for p in range(masks.shape[1]):
                if masks[i, p]:
                    inside = max(inside, farthest[k, p])
                else:
                    outside = min(outside, nearest[k, p])
            out[i, 0] = min(out[i, 0], outside)
            out[i, 1] += outside / clicks
            out[i, 2] += inside / clicks
            out[i, 3] = max(out[i, 3], inside)
    return out


def _reach(masks: Mask, clicks: Clicks) -> Floats:
    return _reach_loop(masks, clicks.nearest, clicks.farthest)


def _nearest(masks: Mask, clicks: Clicks) -> Floats:
    """Return the distance (n,) of an unwanted click from the nearest cell inside."""
    if len(clicks) == 0:
        return np.full(len(masks), FAR)
    least = clicks.nearest.min(axis=0)
    return np.asarray(np.where(masks, least, np.inf).min(axis=1))


def _history(size: Floats, unions: Unions, mask: Mask | None, out: Floats) -> None:
    """Write the overlap with the current mask, growth, origin, and the scores of the merges."""
    if mask is not None:
        before = float(size[mask].sum())
        both = (unions.masks & mask).astype(np.float64) @ size
        now = unions.masks.astype(np.float64) @ size
        out[:, 0] = both / np.maximum(before + now - both, 1.0)
        out[:, 1] = np.log(np.maximum(now, 1.0) / max(before, 1.0))
        out[:, 2] = 1.0
    out[:, 3], out[:, 4], out[:, 5] = unions.made, unions.ended, unions.origin


def _steps(size: Floats, reach: Floats, made: Floats, after: Floats) -> Floats:
    """Return size and reach (n, 9) relative to the adjacent candidates by size, and scores."""
    order = np.argsort(size, kind="stable")
    ranked = np.log(np.maximum(size[order], 1.0))
    far = np.log(np.maximum(reach[order], 1e-4))
    rows = np.empty((len(order), SUPPORT - STEPS))
    none = 3.0
    rows[:, 0] = np.diff(ranked, append=ranked[-1:] + none)
    rows[:, 1] = np.diff(ranked, prepend=ranked[:1] - none)
    rows[:, 2] = np.diff(far, append=far[-1:] + none)
    rows[:, 3] = np.diff(far, prepend=far[:1] - none)
    ended = after[order]
    rows[:, 4] = np.maximum.accumulate(ended[::-1])[::-1]
    rows[:, 5] = np.minimum.accumulate(np.append(8.0, ended[:-1]))
    rows[:, 6] = ended - rows[:, 5]
    rows[:, 7] = np.arange(len(order)) / max(len(order) - 1, 1)
    rows[:, 8] = made[order] - ended
    out = np.empty_like(rows)
    out[order] = rows
    return out
