"""Train the weights of object selection from generated scenes, and write them into the package.

python benchmarks/train_selection.py [--only SENSOR ...] [--leave KIND ...] [--out weights.npz]

Needs LightGBM (``pip install lightgbm``; nothing at run time does).  The same seeds give the same
file.  ``--only`` trains for some kinds of sensors and keeps the package's weights for the others.
``--leave`` trains without a kind of scene, so that it can be scored on it.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import lightgbm
import numpy as np
from numpy.typing import NDArray
from object_clicks import LEAST_POINTS, MOST_OBJECTS, as_mask, next_click, objects, stroke
from object_scenes import GENERATED, HELD_OUT, Scene

from pointbrush.selection.objects import ObjectOptions, ObjectState
from pointbrush.selection.objects.choosing import propose
from pointbrush.selection.objects.clicks import place_clicks
from pointbrush.selection.objects.growing import Linked, grow_region
from pointbrush.selection.objects.options import LadderOptions
from pointbrush.selection.objects.preparing import part_frame
from pointbrush.selection.objects.state import Parts, state_of
from pointbrush.selection.objects.sums import COUNT
from pointbrush.selection.objects.tree import FEATURES, record_tree
from pointbrush.selection.objects.unions import Unions
from pointbrush.selection.objects.value import SUPPORT, VALUES
from pointbrush.selection.objects.weights import (
    FILE,
    Forest,
    Weights,
    load_weights,
    save_weights,
)
from pointbrush.sensor_kind import SENSOR_KINDS


@dataclass(frozen=True)
class Lesson:
    """Frames of each kind, seeds from ``first`` on; whether regions that grow are learnt besides;
    size of the value model."""

    frames: Mapping[str, int]
    first: int = 0
    grown: bool = True
    value_trees: int = 160
    value_leaves: int = 31
    clicked: int = 12
    """Objects of a scene that are clicked at most, evenly chosen."""

    @property
    def options(self) -> ObjectOptions:
        """Options by which its candidates are made."""
        growing = LadderOptions().growing if self.grown else frozenset()
        return ObjectOptions(ladder=LadderOptions(growing=growing))


EVERY = Lesson(
    {
        "juggling": 10,
        "tabletop": 16,
        "walking": 10,
        "contacts": 44,
        "view": 40,
        "scan": 36,
        "street": 40,
    },
    grown=False,
    clicked=MOST_OBJECTS,
)
"""What belongs together for lidar and depth cameras, and what is worth showing for lidar."""
VIEWS = Lesson(
    {"contacts": 44, "tabletop": 24, "view": 12, "juggling": 6, "walking": 4},
    first=100,
    value_trees=260,
    value_leaves=47,
)
"""What is worth showing for depth cameras: scenes that the above has not seen."""
ROOMS = Lesson({"home": 18, "scan": 6})
"""Both for scanned rooms; all sizes of the sets below are for a lesson."""
ROUNDS = 3
MERGE_ROWS, VALUE_ROWS = 260_000, 260_000
SCORED = 60_000
"""Pairs noted in one tree."""
GROWN_OBJECTS, GROWN_STEPS, GROWN_SCORED = 12, 120, 1500
"""Regions grown in a scene and round: their number, the pieces added, the pairs noted."""
PURE = 0.7
"""Share of a region that is of its object while it counts."""
EXPONENT = 0.6
"""A pair counts by the size of its smaller part to this power."""
GOOD = 0.6
"""Share of answers of which a nearly right level is taken; of the others any."""
SESSIONS = 5
"""Sessions that are simulated on each object."""
COMMON = {
    "learning_rate": 0.1,
    "lambda_l2": 5.0,
    "num_threads": 1,
    "deterministic": True,
    "force_row_wise": True,
    "seed": 7,
    "verbosity": -1,
}
MERGE = COMMON | {"objective": "binary", "num_leaves": 31, "min_data_in_leaf": 60}
VALUE = COMMON | {
    "objective": "regression",
    "min_data_in_leaf": 80,
    "feature_fraction": 0.5,
}
MERGE_TREES = 60


@dataclass(eq=False)
class Example:
    """A scene up to its pieces; ``truth`` (P,) the instance most of a piece is of, else -1."""

    scene: Scene
    parts: Parts
    truth: NDArray[np.int64]


def example(scene: Scene) -> Example:
    """Cut a scene into pieces and find what each is of."""
    parts = part_frame(scene.frame, ObjectOptions())
    piece = parts.piece[parts.of_point]
    numbers, which = np.unique(scene.instance, return_inverse=True)
    counts = np.zeros((len(parts.pieces.sums), len(numbers)), np.int64)
    np.add.at(counts, (piece, which), 1)
    best = counts.argmax(axis=1)
    most = counts[np.arange(len(counts)), best]
    truth = np.where(2 * most > counts.sum(axis=1), numbers[best], -1)
    return Example(scene, parts, truth)


def node_truth(truth: NDArray[np.int64], parent: NDArray[Any], size: NDArray[Any]) -> NDArray[Any]:
    """Instances of all nodes: that of the larger part."""
    result = np.concatenate([truth, np.full(len(parent) - len(truth), -2)])
    largest = np.zeros(len(parent))
    for node, above in enumerate(parent.tolist()):
        if above >= 0 and size[node] > largest[above]:
            largest[above], result[above] = size[node], result[node]
    return result


def forest(booster: lightgbm.Booster) -> Forest:
    """Trees of a booster as plain arrays."""
    feature, threshold, left, right = [], [], [], []

    def add(node: dict[str, Any]) -> int:
        at = len(feature)
        leaf = "leaf_value" in node
        feature.append(-1 if leaf else node["split_feature"])
        threshold.append(node["leaf_value"] if leaf else node["threshold"])
        left.append(at)
        right.append(at)
        if not leaf:
            left[at] = add(node["left_child"])
            right[at] = add(node["right_child"])
        return at

    roots = [add(tree["tree_structure"]) for tree in booster.dump_model()["tree_info"]]
    return Forest(
        np.array(feature, np.int16),
        np.array(threshold, np.float32),
        np.array(left, np.int32),
        np.array(right, np.int32),
        np.array(roots, np.int32),
    )


def fit(
    options: dict[str, Any],
    trees: int,
    rows: NDArray[Any],
    wanted: NDArray[Any],
    weight: NDArray[Any],
    most: int,
) -> Forest:
    """Train on at most so many rows, chosen at random."""
    if len(rows) > most:
        chosen = np.random.default_rng(3).choice(len(rows), most, replace=False)
        chosen.sort()
        rows, wanted, weight = rows[chosen], wanted[chosen], weight[chosen]
    data = lightgbm.Dataset(rows, wanted, weight=weight, params=COMMON)
    return forest(lightgbm.train(options, data, trees))


NO_MODEL = Forest(
    np.full(1, -1, np.int16),
    np.zeros(1, np.float32),
    np.zeros(1, np.int32),
    np.zeros(1, np.int32),
    np.zeros(1, np.int32),
)
Rows = tuple[NDArray[Any], NDArray[Any], NDArray[Any]]


def merge_rows(one: Example, model: Forest, most: int, rng: np.random.Generator) -> Rows:
    """Numbers, truths and weights of the pairs that a model scores; the first ones without it."""
    first = len(one.parts.pieces.pairs)
    known = first if model is NO_MODEL else SCORED
    tree, scored = record_tree(one.parts.pieces, one.parts.size**2, model, known)
    instance = node_truth(one.truth, tree.parent, tree.sums[:, COUNT])
    a, b = instance[scored.nodes].T
    counts = (a >= 0) & (b >= 0) & ((a > 0) | (b > 0))
    chosen = np.flatnonzero(counts)
    if len(chosen) > most:
        chosen = np.sort(rng.choice(chosen, most, replace=False))
    size = tree.sums[scored.nodes[chosen, 0], COUNT]
    return scored.rows[chosen], (a == b)[chosen].astype(float), size**EXPONENT


def grown_rows(one: Example, model: Forest, rng: np.random.Generator) -> Rows:
    """The same of the pairs that are scored while regions grow from pieces of the objects."""
    sums, truth = one.parts.pieces.sums, one.truth
    rows, wanted, weight = [np.empty((0, FEATURES))], [np.empty(0)], [np.empty(0)]
    found = np.unique(truth[truth > 0])
    for number in rng.permutation(found)[:GROWN_OBJECTS].tolist():
        seeds = rng.choice(np.flatnonzero(truth == number), 1)
        nothing = np.zeros(len(truth), np.bool_)
        between = one.parts.pieces.between.astype(np.float32)
        linked = Linked(sums, one.parts.pieces.pairs.astype(np.int32), between)
        order, _, scored, asked = grow_region(
            linked, seeds, nothing, one.parts.size**2, model, GROWN_STEPS, GROWN_SCORED
        )
        # A region that has left its object says nothing about it.
        size = np.append(sums[seeds, COUNT], sums[order, COUNT])
        own = np.append(True, truth[order] == number)
        pure = np.cumsum(size * own) >= PURE * np.cumsum(size)
        end = len(pure) if pure.all() else int(pure.argmin())
        counts = (asked[:, 0] < end) & (truth[asked[:, 1]] >= 0)
        chosen = np.flatnonzero(counts)
        smaller = np.minimum(np.cumsum(size)[asked[chosen, 0]], sums[asked[chosen, 1], COUNT])
        rows.append(scored[chosen])
        wanted.append((truth[asked[chosen, 1]] == number).astype(float))
        weight.append(smaller**EXPONENT)
    return np.concatenate(rows), np.concatenate(wanted), np.concatenate(weight)


def train_merge(examples: Sequence[Example], lesson: Lesson) -> Forest:
    """Grow trees with the model so far, add what it was asked, refit."""
    rng = np.random.default_rng(5)
    model, seen = NO_MODEL, []
    most = MERGE_ROWS * 2 // max(len(examples) * (ROUNDS + 1), 1)
    for turn in range(ROUNDS):
        for one in examples:
            # Each scene and round counts alike.
            seen.append(_evened(*merge_rows(one, model, most, rng)))
            if lesson.grown and model is not NO_MODEL:
                seen.append(_evened(*grown_rows(one, model, rng)))
        rows, wanted, weight = (np.concatenate(column) for column in zip(*seen, strict=True))
        model = fit(MERGE, MERGE_TREES, rows, wanted, weight, MERGE_ROWS)
        print(f"  round {turn}: {len(rows)} pairs, {wanted.mean():.2f} the same", flush=True)
    return model


def _evened(rows: NDArray[Any], wanted: NDArray[Any], weight: NDArray[Any]) -> Rows:
    return rows, wanted, weight / max(weight.sum(), 1e-9) * len(rows)


def grow(one: Example, model: Forest) -> ObjectState:
    """State of an example under a merge model."""
    parts = one.parts
    tree, _ = record_tree(parts.pieces, parts.size**2, model, 0)
    return state_of(parts, one.scene.frame.sensor, tree)


def overlaps(state: ObjectState, unions: Unions, truth: NDArray[np.bool_]) -> NDArray[Any]:
    """IoU (n,) of unions with the truth (N,), over points."""
    piece = state.piece[state.of_point]
    size = np.bincount(piece, minlength=state.piece_count).astype(float)
    hits = np.bincount(piece[truth], minlength=state.piece_count).astype(float)
    masks = unions.masks.astype(float)
    both = masks @ hits
    return both / (masks @ size + hits.sum() - both)


def session(
    state: ObjectState,
    scene: Scene,
    model: Forest,
    lesson: Lesson,
    truth: NDArray[np.bool_],
    first: NDArray[Any],
    further: int,
    rng: np.random.Generator,
) -> list[tuple[NDArray[Any], NDArray[Any]]]:
    """Rows and overlaps of all candidates of a simulated session."""
    xyz = scene.frame.xyz
    wanted, unwanted, found = first, np.empty((0, 3)), []
    taken: NDArray[np.bool_] | None = None
    for _ in range(further + 1):
        yes = place_clicks(state, wanted, "positives", first=taken is None)
        no = place_clicks(state, unwanted, "negatives", first=taken is None)
        proposals = propose(state, yes, no, taken, model, lesson.options)
        good = overlaps(state, proposals.unions, truth)
        features = proposals.features if lesson.grown else proposals.features[:, :SUPPORT]
        found.append((features, good))
        # People also go on from a level that was wrong: it is to be seen through.
        better = np.flatnonzero(good >= good.max() - (0.15 if rng.random() < GOOD else 1.0))
        taken = as_mask(proposals.points(state, [int(rng.choice(better))])[0], len(xyz))
        click = next_click(xyz, truth, taken)
        if click is None:
            break
        at, adds = click
        if adds:
            wanted = np.concatenate([wanted, at[None]])
        else:
            unwanted = np.concatenate([unwanted, at[None]])
    return found


def value_rows(one: Example, model: Forest, lesson: Lesson, seed: int) -> Rows:
    """Rows of sessions on the objects of a scene."""
    rng = np.random.default_rng([seed, 61])
    state, scene = grow(one, model), one.scene
    rows, wanted = [np.empty((0, VALUES if lesson.grown else SUPPORT))], [np.empty(0)]
    every = objects(scene.instance, LEAST_POINTS[scene.frame.sensor])
    for number in every[:: max(1, -(-len(every) // lesson.clicked))]:
        truth = scene.instance == number
        inside = np.flatnonzero(truth)
        centre = next_click(scene.frame.xyz, truth, None)
        starts = [] if centre is None else [(centre[0][None], 3)]
        for k in range(SESSIONS - 1):
            if k == 0:
                starts.append((stroke(scene.frame.xyz, truth, int(rng.integers(3, 6)), rng), 1))
            else:
                starts.append((scene.frame.xyz[rng.choice(inside, 1)].astype(float), k % 2))
        for first, further in starts:
            for numbers, good in session(state, scene, model, lesson, truth, first, further, rng):
                rows.append(numbers)
                wanted.append(good)
    found = np.concatenate(rows)
    return found, np.concatenate(wanted), np.full(len(found), 1.0)


def train_value(examples: Sequence[Example], halves: Sequence[Forest], lesson: Lesson) -> Forest:
    """Sessions on each scene, its tree grown by the merge model that has not seen it."""
    seen = []
    for k, one in enumerate(examples):
        rows, wanted, weight = value_rows(one, halves[1 - k % 2], lesson, k)
        seen.append((rows, wanted, weight / max(len(rows), 1) ** 0.5))
    rows, wanted, weight = (np.concatenate(column) for column in zip(*seen, strict=True))
    print(f"  {len(rows)} candidates, mean IoU {wanted.mean():.2f}", flush=True)
    options = VALUE | {"num_leaves": lesson.value_leaves}
    return fit(options, lesson.value_trees, rows, wanted, weight, VALUE_ROWS)


def train(lesson: Lesson, leave: Sequence[str]) -> Weights:
    """Merge model and value model of a lesson."""
    made = examples(lesson, leave)
    halves = [train_merge(made[k::2], lesson) for k in range(2)]
    return Weights(train_merge(made, lesson), train_value(made, halves, lesson))


def examples(lesson: Lesson, leave: Sequence[str]) -> list[Example]:
    """Training scenes of all kinds but those left out, kinds mixed."""
    order = []
    for kind, count in lesson.frames.items():
        if kind not in leave:
            order += [(k / count, kind, lesson.first + k) for k in range(count)]
    assert lesson.first + max(lesson.frames.values()) < HELD_OUT
    made = [example(GENERATED[kind](seed)) for _, kind, seed in sorted(order)]
    print(f"{len(made)} scenes, {sum(len(e.truth) for e in made)} pieces", flush=True)
    return made


def main() -> None:
    """Train and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="*", default=list(SENSOR_KINDS), choices=SENSOR_KINDS)
    parser.add_argument("--leave", nargs="*", default=[], choices=GENERATED)
    parser.add_argument("--out", type=Path, default=FILE)
    given = parser.parse_args()
    weights = load_weights(FILE)
    if "lidar" in given.only:
        weights["lidar"] = train(EVERY, given.leave)
    if "camera" in given.only:
        merge = weights["lidar"].merge
        value = train_value(examples(VIEWS, given.leave), [merge, merge], VIEWS)
        weights["camera"] = Weights(merge, value)
    if "room" in given.only:
        weights["room"] = train(ROOMS, given.leave)
    save_weights(given.out, weights)
    print(f"{given.out}: {given.out.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    assert FEATURES <= 127
    main()
