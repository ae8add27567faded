"""Labels by example over REST: a simulated annotator, and the scores after so many strokes.

python benchmarks/bench_example.py [--sets aerial street room] [--ways worst doubt random]

A stroke is a ball of fixed radius with the class of the point in its middle; it is made smaller
where a tenth of what it takes is of other classes.  ``worst``: where most points are wrong;
``doubt``: where `GET …/doubt` leads; ``random``: at a random point.  ``there`` is the taught
frame, ``later`` the drive's frame 9, ``elsewhere`` other tiles, drives and rooms.  ``picture``:
from a stroke's call to the answer with every point's class.
"""

from __future__ import annotations

import argparse
import io
import tempfile
import time
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import httpx
import numpy as np
from bench_effort import serving
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.classify.features import ExampleFrame, describe, scale_of
from pointbrush.classify.forest import learn
from pointbrush.classify.options import FeatureOptions, ForestOptions
from pointbrush.samples.classes import (
    Classified,
    classified_drive,
    classified_room,
    classified_tile,
    scores,
)
from pointbrush.sequences import import_frames

AT = (5, 10, 20, 40)
"""Strokes after which the scores are taken."""
SEEDS = (900, 901)
TILES = (0, 1, 2, 3)
RADIUS = {"aerial": 2.0, "street": 0.6, "room": 0.15}
"""Metres of a stroke."""
PURE = 0.9
TRIES = 3
MOST = 20_000
EIGEN, NEIGHBOURS = 11, 200
"""Features of pgeof at a radius, and points of a ball that it looks at at most."""


class Place(NamedTuple):
    """A frame of a recording, and its classes."""

    recording: str
    frame: int
    made: Classified


def recordings(kind: str) -> dict[str, list[Classified]]:
    if kind == "aerial":
        return {f"aerial-{seed}": [classified_tile(seed)] for seed in TILES}
    if kind == "room":
        return {f"room-{seed}": [classified_room(seed)] for seed in SEEDS}
    drives = {f"street-{seed}": list(classified_drive(seed, 10)) for seed in SEEDS}
    return {name: [frames[0], frames[9]] for name, frames in drives.items()}


def write(folder: Path, made: dict[str, list[Classified]], up: str) -> None:
    for name, frames in made.items():
        target = folder / "workspace" / "sequences" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        import_frames(
            (each.frame for each in frames), target, sequence_id=name, name=name, fps=10.0, up=up
        )


class Annotator:
    """Paints in one frame; ``others`` are only looked at."""

    def __init__(self, api: httpx.Client, kind: str, place: Place, others: list[Place]) -> None:
        self.api, self.place, self.others = api, place, others
        self.xyz = np.asarray(place.made.frame.xyz, np.float64)
        self.truth = place.made.truth.astype(np.int64)
        self.tree, self.radius = cKDTree(self.xyz), RADIUS[kind]
        self.seconds: list[float] = []

    def begin(self, name: str) -> None:
        self.labels = [0]
        for kind in self.place.made.classes:
            where = f"/sequences/{self.place.recording}/labels"
            made = self.api.post(where, json={"name": kind}).raise_for_status().json()
            self.labels.append(made["id"])
        body = {
            "name": name,
            "recordings": [self.place.recording],
            "classes": list(self.place.made.classes),
        }
        made = self.api.post("/classifiers", json=body).raise_for_status().json()
        self.classifier = made["id"]
        self.taught = np.zeros(len(self.truth), bool)

    def stroke(self, point: int) -> None:
        radius, near = self.radius, np.empty(0, np.int64)
        for _ in range(TRIES):
            near = np.array(self.tree.query_ball_point(self.xyz[point], radius))
            if (self.truth[near] == self.truth[point]).mean() >= PURE:
                break
            radius /= 2
        self.taught[near] = True
        label = self.labels[int(self.truth[point])]
        if label:
            sample = {"origin": self.xyz[point].tolist(), "direction": [0, 0, -1], "t": 0}
            body = {"label": label, "tool": "paint", "shape": "sphere", "radius": radius,
                    "samples": [sample]}  # fmt: skip
            where = f"/sequences/{self.place.recording}/frames/{self.place.frame}/strokes"
            self.api.post(where, json=body).raise_for_status()

    def predict(self, place: Place) -> NDArray[np.int64]:
        where = f"/sequences/{place.recording}/frames/{place.frame}/prediction"
        answer = self.api.post(where, json={"classifier": self.classifier}).raise_for_status()
        with np.load(io.BytesIO(answer.content)) as found:
            return found["class"].astype(np.int64)

    def worst(self, found: NDArray[np.int64], rng: np.random.Generator) -> int:
        wrong = np.flatnonzero((found != self.truth) & (self.truth > 0) & ~self.taught)
        if not len(wrong):
            return int(rng.integers(len(self.truth)))
        cube = np.floor(self.xyz[wrong] / (2 * self.radius)).astype(np.int64)
        _, which, held = np.unique(cube, axis=0, return_inverse=True, return_counts=True)
        members = wrong[which.ravel() == held.argmax()]
        away = np.linalg.norm(self.xyz[members] - np.median(self.xyz[members], axis=0), axis=1)
        return int(members[away.argmin()])

    def doubt(self) -> int:
        query = {"classifier": self.classifier, "frame": self.place.frame, "most": 1}
        where = f"/sequences/{self.place.recording}/doubt"
        found = self.api.get(where, params=query).raise_for_status().json()
        return int(self.tree.query(found[0]["centre"])[1])

    def run(self, way: str, seed: int) -> dict[int, list[dict[str, float]]]:
        """Scores after so many strokes: there, and in each of the others."""
        rng, reached = np.random.default_rng(seed), {}
        found = np.zeros(len(self.truth), np.int64)
        for number in range(1, max(AT) + 1):
            if way == "worst":
                point = self.worst(found, rng)
            elif way == "doubt" and number > 1:
                point = self.doubt()
            else:
                point = int(rng.integers(len(self.truth)))
            start = time.perf_counter()
            self.stroke(point)
            if way != "random" or number in AT:
                found = self.predict(self.place)
                self.seconds.append(time.perf_counter() - start)
            if number in AT:
                count = len(self.place.made.classes)
                here = scores(self.truth, found, count)
                there = [scores(o.made.truth, self.predict(o), count) for o in self.others]
                reached[number] = [dict(here), *map(dict, there)]
        return reached


def score(api: httpx.Client, kind: str, made: dict[str, list[Classified]], ways: list[str],
          turns: int) -> None:  # fmt: skip
    """Print a line for each way and number of strokes: mean and worst over what was taught."""
    names = list(made)
    table: dict[tuple[str, int, str], list[dict[str, float]]] = defaultdict(list)
    seconds: list[float] = []
    for turn, name in enumerate(names[:turns]):
        for way in ways:
            others = [Place(name, k, each) for k, each in enumerate(made[name]) if k]
            others += [Place(other, 0, made[other][0]) for other in names if other != name]
            annotator = Annotator(api, kind, Place(name, 0, made[name][0]), others)
            annotator.begin(f"{name} {way}")
            reached = annotator.run(way, turn)
            if way == "worst":
                peers(kind, annotator, others)
            for number, found in reached.items():
                table[way, number, "there"].append(found[0])
                for other, reached_there in zip(others, found[1:], strict=True):
                    where = "later" if other.recording == name else "elsewhere"
                    table[way, number, where].append(reached_there)
            seconds += annotator.seconds[2:]
            clean(api, names)
    for (way, number, where), found in table.items():
        figures = "  ".join(
            f"{key} {np.mean([f[key] for f in found]):.3f} (worst {min(f[key] for f in found):.3f})"
            for key in ("OA", "mIoU")
        )
        print(f"{kind:7} {way:7} {number:3} strokes  {where:10} {figures}", flush=True)
    told = np.quantile(seconds, [0.5, 0.95])
    points = len(made[names[0]][0].truth)
    print(f"{kind:7} picture after a stroke, {points:,} points: median {told[0]:.2f} s, "
          f"p95 {told[1]:.2f} s", flush=True)  # fmt: skip


def clean(api: httpx.Client, names: list[str]) -> None:
    """Take everything back: labels, and with them the strokes, and the classifiers."""
    for name in names:
        for label in api.get(f"/sequences/{name}/labels").json():
            api.delete(f"/sequences/{name}/labels/{label['id']}").raise_for_status()
    for each in api.get("/classifiers").json():
        api.delete(f"/classifiers/{each['id']}").raise_for_status()


def costs() -> None:
    """Print the processor's time for features and for learning, and that of scikit-learn."""
    from sklearn.ensemble import ExtraTreesClassifier

    made = classified_tile(0)
    xyz = np.asarray(made.frame.xyz) - np.asarray(made.frame.xyz).mean(axis=0)
    rng, options, forest = np.random.default_rng(0), FeatureOptions(), ForestOptions()
    frame = ExampleFrame(xyz, intensity=made.frame.intensity)
    describe(frame, 0.5, options)
    start = time.process_time()
    place = describe(frame, 0.5, options)
    spent = time.process_time() - start
    per = 2e5 / len(xyz) * spent
    print(f"features of {len(xyz):,} points: {spent:.2f} s; {per:.2f} s for 200,000")
    truth = np.zeros(len(place.center), np.int64)
    truth[place.of_point] = made.truth
    chosen = rng.choice(np.flatnonzero(truth), MOST, replace=False)
    rows, classes = place.features[chosen], truth[chosen] - 1
    learn(rows[:200], classes[:200], 5, place.features.std(axis=0, dtype=np.float64), forest)
    start = time.process_time()
    learn(rows, classes, 5, place.features.std(axis=0, dtype=np.float64), forest)
    print(f"learning from {MOST:,} examples: {time.process_time() - start:.2f} s")
    peer = ExtraTreesClassifier(forest.trees, max_depth=forest.depth, class_weight="balanced")
    start = time.process_time()
    peer.fit(rows, classes)
    print(f"the same by scikit-learn: {time.process_time() - start:.2f} s")
    start = time.process_time()
    if eigen_features(xyz) is None:
        print("pgeof: not installed here (pip install pgeof)")
    else:
        spent = time.process_time() - start
        print(f"eigen features by pgeof: {2e5 / len(xyz) * spent:.2f} s for 200,000")


def eigen_features(xyz: NDArray[np.float64]) -> NDArray[np.float32] | None:
    """Return pgeof's features (N, 11 a radius) at the radii of ours; None where it is missing."""
    try:
        import pgeof
    except ImportError:
        return None
    places = np.ascontiguousarray(xyz, np.float32)
    size = scale_of(xyz, FeatureOptions())
    every = [pgeof.EFeatureID(k) for k in range(EIGEN)]
    radii = [size * 2.0 ** (level + 1) for level in range(FeatureOptions().levels)]
    found = [pgeof.compute_features_selected(places, radius, NEIGHBOURS, every) for radius in radii]
    return np.nan_to_num(np.hstack(found))


def peers(kind: str, annotator: Annotator, others: list[Place]) -> None:
    """Print what pgeof's features and scikit-learn's extra trees make of the same strokes."""
    from sklearn.ensemble import ExtraTreesClassifier

    here = eigen_features(annotator.xyz)
    if here is None:
        return
    rows = np.flatnonzero(annotator.taught & (annotator.truth > 0))
    trees = ExtraTreesClassifier(100, class_weight="balanced", n_jobs=1, random_state=0)
    trees.fit(here[rows], annotator.truth[rows])
    count = len(annotator.place.made.classes)
    for where, each in [("there", annotator.place), *(("elsewhere", other) for other in others)]:
        features = here
        if each is not annotator.place:
            features = eigen_features(np.asarray(each.made.frame.xyz, np.float64))
        reached = scores(each.made.truth, trees.predict(features), count)
        told = "  ".join(f"{key} {value:.3f}" for key, value in reached.items())
        print(
            f"{kind:7} pgeof and scikit-learn, {len(rows):,} points  {where:10} {told}", flush=True
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    kinds = ("aerial", "street", "room")
    parser.add_argument("--sets", nargs="*", default=list(kinds), choices=kinds)
    parser.add_argument("--ways", nargs="*", default=["worst", "doubt", "random"])
    parser.add_argument("--turns", type=int, default=2, help="recordings that are taught in turn")
    given = parser.parse_args()
    costs()
    for kind in given.sets:
        with tempfile.TemporaryDirectory() as root:
            made = recordings(kind)
            write(Path(root), made, "z" if kind == "aerial" else "y")
            with serving(Path(root) / "workspace") as api:
                score(api, kind, made, given.ways, given.turns)


if __name__ == "__main__":
    main()
