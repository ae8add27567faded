"""Selecting an object: IoU after 1, 2, 3 and 6 clicks, and milliseconds.

python benchmarks/bench_object.py [--weights FILE] [--kinds KIND ...] [--seeds N]

``fill`` is today's region growing, ``ball`` the best radius round the click, ``auto`` the candidate
that is shown first, ``wheel`` the best of the levels offered, ``stroke`` four points along the
object and the best level.  Clicks are simulated in the middle of the larger error.  Generated
scenes have seeds that no training sees; recorded ones are skipped where they are not at hand.
To score a kind that training left out, give weights made by ``train_selection.py --leave KIND``.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from object_clicks import LEAST_POINTS, Mask, as_mask, iou, next_click, objects, stroke
from object_scenes import GENERATED, HELD_OUT, Scene, recorded
from scipy.spatial import cKDTree

from pointbrush.selection import Points
from pointbrush.selection.grow import grow
from pointbrush.selection.objects import Candidate, ObjectState, candidates, load_weights, prepare
from pointbrush.selection.objects.weights import FILE, Weights
from pointbrush.selection.points import Blocks
from pointbrush.sensor_kind import SensorKind

CLICKS = (1, 2, 3, 6)
LINK = {"lidar": 0.3, "camera": 0.05, "room": 0.05}
"""Metres; radius that ``fill`` is given."""
Scores = dict[str, list[float]]
All = Mapping[SensorKind, Weights]


class Session:
    """One object of one scene, selected by clicks."""

    def __init__(self, scene: Scene, state: ObjectState, truth: Mask, weights: Weights) -> None:
        self.scene, self.state, self.truth, self.weights = scene, state, truth, weights
        self.seconds: list[float] = []

    def offered(
        self, wanted: NDArray[Any], unwanted: NDArray[Any], taken: Mask | None
    ) -> list[Candidate]:
        """Candidates for the clicks so far, timed."""
        start = time.perf_counter()
        found = candidates(self.state, wanted, unwanted, taken, weights=self.weights)
        self.seconds.append(time.perf_counter() - start)
        return found

    def mask(self, candidate: Candidate) -> Mask:
        """Candidate as a mask (N,)."""
        return as_mask(candidate.indices, len(self.truth))

    def best(self, found: list[Candidate]) -> Mask:
        """The best level, as a person with a preview would choose."""
        return max((self.mask(each) for each in found), key=lambda mask: iou(mask, self.truth))

    def shown(self, found: list[Candidate]) -> Mask:
        """The level that is shown first."""
        return self.mask(found[0])

    def clicks(self, take: Callable[[list[Candidate]], Mask], first: NDArray[Any]) -> list[float]:
        """IoU after each of the clicks; ``first`` (K, 3) are given at once."""
        wanted, unwanted, taken = first, np.empty((0, 3)), None
        reached: list[float] = []
        for _ in range(max(CLICKS)):
            taken = take(self.offered(wanted, unwanted, taken))
            reached.append(iou(taken, self.truth))
            click = next_click(self.scene.frame.xyz, self.truth, taken)
            if click is None:
                break
            if click[1]:
                wanted = np.concatenate([wanted, click[0][None]])
            else:
                unwanted = np.concatenate([unwanted, click[0][None]])
        return reached + reached[-1:] * (max(CLICKS) - len(reached))


def ball(xyz: NDArray[Any], truth: Mask, at: NDArray[Any]) -> float:
    """Greatest IoU of a ball round a click."""
    order = np.argsort(np.linalg.norm(xyz - at, axis=1), kind="stable")
    hits = np.cumsum(truth[order])
    return float((hits / (np.arange(1, len(order) + 1) + truth.sum() - hits)).max())


def filled(scene: Scene, tree: cKDTree, truth: Mask, at: NDArray[Any]) -> float:
    """IoU of region growing from a click."""
    points = Points(
        np.asarray(scene.frame.xyz, np.float32),
        cast(Blocks, None),  # a frame with a tree is not looked at in blocks
        scene.frame.rgb,
        kdtree=lambda: tree,
    )
    region = np.concatenate(list(grow(points, at, LINK[scene.frame.sensor])))
    return iou(as_mask(region, len(truth)), truth)


def score(scene: Scene, weights: All, peers: bool = True) -> tuple[Scores, list[float], float]:
    """Scores of a scene's objects by name, seconds of the answers, seconds to prepare."""
    pair = weights[scene.frame.sensor]
    start = time.perf_counter()
    state = prepare(scene.frame, weights=pair)
    prepared = time.perf_counter() - start
    scores: Scores = defaultdict(list)
    seconds: list[float] = []
    tree = cKDTree(scene.frame.xyz) if peers else None
    for number in objects(scene.instance, LEAST_POINTS[scene.frame.sensor]):
        truth = scene.instance == number
        click = next_click(scene.frame.xyz, truth, None)
        assert click is not None
        session = Session(scene, state, truth, pair)
        if tree is not None:
            scores["fill"].append(filled(scene, tree, truth, click[0]))
            scores["ball"].append(ball(scene.frame.xyz, truth, click[0]))
        for name, take in (("auto", session.shown), ("wheel", session.best)):
            reached = session.clicks(take, click[0][None])
            for clicks in CLICKS:
                scores[f"{name} {clicks}"].append(reached[clicks - 1])
        marks = stroke(scene.frame.xyz, truth, 4, np.random.default_rng(number))
        found = session.offered(marks, np.empty((0, 3)), None)
        scores["stroke auto"].append(iou(session.shown(found), truth))
        scores["stroke wheel"].append(iou(session.best(found), truth))
        seconds += session.seconds
    return scores, seconds, prepared


def report(name: str, scenes: Iterable[Scene], weights: All, peers: bool = True) -> None:
    """Print the scores of some scenes together."""
    every: Scores = defaultdict(list)
    seconds: list[float] = []
    prepared: list[float] = []
    for scene in scenes:
        if not prepared:
            prepare(scene.frame, weights=weights[scene.frame.sensor])  # compiles
        scores, answers, first = score(scene, weights, peers)
        for key, reached in scores.items():
            every[key] += reached
        seconds += answers
        prepared.append(first)
    if not seconds:
        print(f"{name:12} skipped: not at hand")
        return
    figures = "  ".join(f"{key} {np.mean(reached):.2f}" for key, reached in every.items())
    answer = 1e3 * statistics.median(seconds)
    slow = 1e3 * float(np.quantile(seconds, 0.95))
    print(
        f"{name:12} {len(every['auto 1']):3} objects  {figures}\n"
        f"{'':12} prepared in {1e3 * statistics.median(prepared):.0f} ms, answered in "
        f"{answer:.1f} ms (p95 {slow:.1f})",
        flush=True,
    )


def main() -> None:
    """Print a line or two for each kind of scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--weights", type=Path)
    parser.add_argument("--kinds", nargs="*", default=[*GENERATED, "recorded"])
    parser.add_argument("--seeds", type=int, default=4)
    given = parser.parse_args()
    weights = load_weights(given.weights or FILE)
    for kind in given.kinds:
        made = (
            recorded()
            if kind == "recorded"
            else (GENERATED[kind](HELD_OUT + k) for k in range(given.seeds))
        )
        report(kind, made, weights)


if __name__ == "__main__":
    main()
