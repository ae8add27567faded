"""Extremely randomised trees (Geurts, Ernst and Wehenkel, 2006) as plain arrays.

A node tries some features, each at one threshold between its examples' least and greatest value,
and takes the one that parts the classes best.  Classes weigh the same, however many examples.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.options import ForestOptions
from pointbrush.compiled import compiled, innermost

Features = NDArray[np.float32]
Floats = NDArray[np.float64]
Grown = tuple[NDArray[np.int16], NDArray[np.float32], NDArray[np.int32], Floats]
"""One tree: features, thresholds, links and chances of its leaves."""
LEAF = -1
MOST_THREADS = 4
GROUPS = 16
"""Groups of trees; each leaves other examples out, so that they tell how sure the trees are."""
T = TypeVar("T")
R = TypeVar("R")


class Trees(NamedTuple):
    """Trees that share their arrays; children come after their node.

    ``feature`` (n,) int16, -1 for a leaf; ``threshold`` (n,) float32: left when a value is not
    above it; ``left`` (n,) int32, its right child is the next, and of a leaf its row of
    ``chance`` (leaves, classes) float32; ``roots`` (trees,) int32.
    """

    feature: NDArray[np.int16]
    threshold: NDArray[np.float32]
    left: NDArray[np.int32]
    roots: NDArray[np.int32]
    chance: NDArray[np.float32]


def learn(
    features: Features,
    classes: NDArray[np.int64],
    count: int,
    spread: Floats,
    options: ForestOptions,
    share: Floats | None = None,
    fold: NDArray[np.int64] | None = None,
) -> Trees:
    """Learn ``count`` classes from examples (n, F) and their classes (n,).

    ``spread`` (F,) standard deviations of the features in whole frames.  Noise is
    added to the examples, so that no threshold fits a narrow gap between a few of them.  The same
    examples give the same trees.  ``share`` (n,): weight of an example beside others of its class;
    ``fold`` (n,): the group of trees that does not learn it, -1 for none.
    """
    rng = np.random.default_rng(0)
    share = np.ones(len(classes)) if share is None else share
    fold = np.full(len(classes), -1) if fold is None else fold
    times = max(1, options.copies // max(len(classes), 1))
    features, classes = np.repeat(features, times, axis=0), np.repeat(classes, times)
    share, fold = np.repeat(share, times), np.repeat(fold, times)
    shaken = rng.standard_normal(features.shape, np.float32)
    shaken = features + shaken * (options.shake * spread).astype(np.float32)
    columns = np.ascontiguousarray(shaken.T)  # a column at a time is looked at
    seeds = rng.integers(1, 2**31, options.trees).tolist()
    rules = _Rules(count, options.depth, options.fewest, options.tried, options.smoothing)

    def grown(tree: int) -> Grown:
        kept = np.flatnonzero(fold != tree % GROUPS)
        held = np.bincount(classes[kept], share[kept], minlength=count)
        weight = share * (len(kept) / max((held > 0).sum(), 1) / np.maximum(held, 1e-12)[classes])
        return _grow(_Examples(columns, classes, weight), kept, rules, seeds[tree])

    return _joined(_threaded(grown, range(options.trees)))


def groups_of(trees: Trees) -> list[Trees]:
    """Return the groups of trees that left out the same examples."""
    groups = range(min(GROUPS, len(trees.roots)))
    return [trees._replace(roots=trees.roots[group::GROUPS]) for group in groups]


def _threaded(work: Callable[[T], R], parts: Sequence[T]) -> list[R]:
    """Call compiled ``work`` of each part in threads, so that all processors are used."""
    with ThreadPoolExecutor(min(os.cpu_count() or 1, MOST_THREADS)) as pool:
        return list(pool.map(work, parts))


def _joined(made: Sequence[Grown]) -> Trees:
    roots, starts, at, leaf = [], [], 0, 0
    for feature, _, _, chance in made:
        roots.append(at)
        starts.append(leaf)
        at, leaf = at + len(feature), leaf + len(chance)
    left = [
        np.where(feature < 0, links + start, links + root)
        for (feature, _, links, _), root, start in zip(made, roots, starts, strict=True)
    ]
    return Trees(
        np.concatenate([each[0] for each in made]).astype(np.int16),
        np.concatenate([each[1] for each in made]).astype(np.float32),
        np.concatenate(left).astype(np.int32),
        np.array(roots, np.int32),
        np.concatenate([each[3] for each in made]).astype(np.float32),
    )


def is_shallow(trees: Trees, most: int) -> bool:
    """Return whether at most ``most`` nodes lie on any way from a root to a leaf."""
    nodes = np.unique(trees.roots)
    for _ in range(most):
        nodes = nodes[trees.feature[nodes] >= 0]
        if not len(nodes):
            return True
        children = trees.left[nodes]
        nodes = np.unique(np.concatenate([children, children + 1]))
    return False


@innermost
def _random(state: NDArray[np.uint64]) -> float:
    """Return the next number of a generator (xorshift), 0 to 1."""
    x = state[0]
    x ^= x << np.uint64(13)
    x ^= x >> np.uint64(7)
    x ^= x << np.uint64(17)
    state[0] = x
    return float(x >> np.uint64(11)) / 9007199254740992.0


class _Examples(NamedTuple):
    """Features (F, n), classes (n,) and weights (n,) of examples."""

    columns: Features
    classes: NDArray[np.int64]
    weight: Floats


class _Rules(NamedTuple):
    """Number of classes, and the ``ForestOptions`` of one tree."""

    kinds: int
    depth: int
    fewest: int
    tried: int
    smoothing: float


@compiled
def _grow(
    examples: _Examples, kept: NDArray[np.int64], rules: _Rules, seed: int
) -> tuple[NDArray[np.int16], NDArray[np.float32], NDArray[np.int32], Floats]:
    """Grow one tree of the examples ``kept``; its links count from its own first node and leaf."""
    columns, classes, weight = examples
    kinds, depth, fewest, smoothing = rules.kinds, rules.depth, rules.fewest, rules.smoothing
    count = len(kept)
    state = np.array([seed], np.uint64)
    for _ in range(8):
        _random(state)
    room = 2 * count + 1
    feature = np.full(room, LEAF, np.int16)
    threshold, left = np.zeros(room, np.float32), np.zeros(room, np.int32)
    chance = np.zeros((count + 1, kinds))
    order = kept.copy()
    # Nodes that wait: node, first and stop of its examples in ``order``, depth.
    waiting = np.empty((2 * depth + 4, 4), np.int64)
    waiting[0] = (0, 0, count, 0)
    open_, nodes, leaves = 1, 1, 0
    totals, parts = np.zeros(kinds), np.zeros(kinds)
    while open_:
        open_ -= 1
        node, first, stop, down = waiting[open_]
        totals[:] = 0.0
        for i in range(first, stop):
            totals[classes[order[i]]] += weight[order[i]]
        best, cut = -1, np.float32(0.0)
        if down < depth and stop - first >= 2 * fewest and (totals > 0).sum() > 1:
            best, cut = _question(examples, order[first:stop], rules, totals, parts, state)
        if best < 0:
            left[node] = leaves
            whole = totals.sum() + smoothing * kinds
            for k in range(kinds):
                chance[leaves, k] = (totals[k] + smoothing) / whole
            leaves += 1
            continue
        i, j = first, stop - 1
        while i <= j:
            if columns[best, order[i]] <= cut:
                i += 1
            else:
                order[i], order[j] = order[j], order[i]
                j -= 1
        feature[node], threshold[node], left[node] = best, cut, nodes
        waiting[open_] = (nodes + 1, i, stop, down + 1)
        waiting[open_ + 1] = (nodes, first, i, down + 1)
        open_ += 2
        nodes += 2
    grown = feature[:nodes].copy(), threshold[:nodes].copy(), left[:nodes].copy()
    return grown[0], grown[1], grown[2], chance[:leaves].copy()


@innermost
def _question(
    examples: _Examples, chosen: NDArray[np.int64], rules: _Rules, totals: Floats, parts: Floats,
    state: NDArray[np.uint64],
) -> tuple[int, np.float32]:  # fmt: skip
    """Return the feature and threshold that part ``chosen`` examples best, or -1."""
    columns, classes, weight = examples
    width, tried = len(columns), rules.tried
    best, cut, most = -1, np.float32(0.0), -1.0
    looked = 0
    for _ in range(3 * tried):
        if looked >= tried:
            break
        f = int(_random(state) * width)
        low = high = columns[f, chosen[0]]
        for i in chosen[1:]:
            value = columns[f, i]
            low, high = min(low, value), max(high, value)
        if not low < high:
            continue
        looked += 1
        at = np.float32(low + _random(state) * (high - low))
        if at >= high:
            at = low
        parts[:] = 0.0
        held = 0
        for i in chosen:
            if columns[f, i] <= at:
                parts[classes[i]] += weight[i]
                held += 1
        if min(held, len(chosen) - held) < rules.fewest:
            continue
        gain = _purity(totals, parts)
        if gain > most:
            best, cut, most = f, at, gain
    return best, cut


@innermost
def _purity(totals: Floats, parts: Floats) -> float:
    """Rate a node's two parts: the more of one class each is, the higher."""
    left = right = left_squares = right_squares = 0.0
    for k in range(len(totals)):
        rest = totals[k] - parts[k]
        left += parts[k]
        right += rest
        left_squares += parts[k] * parts[k]
        right_squares += rest * rest
    return left_squares / left + right_squares / right


ROWS = 512
"""Rows that go through one tree after another, so that both stay near the processor."""


def probabilities(trees: Trees, features: Features) -> NDArray[np.float32]:
    """Return the chance (n, classes) of each class by the mean of all trees."""
    out = np.zeros((len(features), trees.chance.shape[1]), np.float32)
    share = -(-len(features) // MOST_THREADS) or 1
    starts = range(0, len(features), share)
    _threaded(lambda at: _add(trees, features[at : at + share], out[at : at + share]), starts)
    return out


@compiled
def _add(trees: Trees, features: Features, out: NDArray[np.float32]) -> None:
    """Add the mean chance (n, classes) of all trees to ``out``."""
    feature, threshold, left, roots, chance = trees
    kinds = chance.shape[1]
    share = np.float32(1.0 / len(roots))
    for start in range(0, len(features), ROWS):
        stop = min(start + ROWS, len(features))
        for root in roots:
            for i in range(start, stop):
                at = root
                while feature[at] >= 0:
                    at = left[at] + (features[i, feature[at]] > threshold[at])
                for k in range(kinds):
                    out[i, k] += share * chance[left[at], k]
