"""Labels by example over REST: a simulated annotator, and the scores after so many strokes.

python benchmarks/bench_example.py [--sets aerial street terrain room] [--split checking]

Real recordings are those of ``example_sets``; ``room`` is generated.

A stroke is a ball of fixed radius with the class of the point in its middle; it is made smaller
where a tenth of what it takes is of other classes.  ``worst``: where most points are wrong;
``doubt``: the piece of the first doubt is answered; ``random``: at a random point.  ``there`` is
the taught frame, ``later`` the drive's last frame, ``elsewhere`` other parts, drives, samples and
rooms.
``start``: classifiers start from the other recordings, which are labelled completely before.
``expected`` is the score less the accuracy of the points that are not painted.
``picture``: from a stroke's call to the answer with every point's class.
"""

from __future__ import annotations

import argparse
import io
import tempfile
import time
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import httpx
import numpy as np
from bench_effort import serving
from example_sets import CHECKING, FEWEST, TUNING, Sets, real_sets
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.classify.features import ExampleFrame, describe
from pointbrush.classify.forest import learn
from pointbrush.classify.options import FeatureOptions, ForestOptions
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush_samples.classes import Classified, classified_room, classified_tile

AT = (10, 20, 40, 80)
"""Strokes after which the scores are taken."""
SEEDS = (900, 901)
RADIUS = {"aerial": 8.0, "street": 0.6, "terrain": 4.0, "room": 0.15}
"""Metres of a stroke; the aerial tiles have a point each 2 m."""
PURE = 0.9
TRIES = 3
MOST = 20_000


class Place(NamedTuple):
    """A frame of a recording, and its classes."""

    recording: str
    frame: int
    made: Classified


def recordings(kind: str, split: dict[str, tuple[str, ...]]) -> Sets:
    """Return each recording's first and last frame."""
    if kind == "room":
        return {f"room-{seed}": [classified_room(seed)] for seed in SEEDS}
    every = real_sets(kind, split[kind])
    return {name: frames[:: max(len(frames) - 1, 1)] for name, frames in every.items()}


def scores(truth: NDArray[np.integer], found: NDArray[np.integer], count: int) -> dict[str, float]:
    """Return overall accuracy, and the mean IoU of classes with at least ``FEWEST`` points."""
    table = np.bincount(truth.astype(np.int64) * (count + 1) + found, minlength=(count + 1) ** 2)
    table = table.reshape(count + 1, count + 1)
    hit, there = np.diag(table)[1:], table[1:].sum(axis=1)
    iou = hit / np.maximum(there + table[1:, 1:].sum(axis=0) - hit, 1)
    return {"OA": float(hit.sum() / there.sum()), "mIoU": float(iou[there >= FEWEST].mean())}


def write(folder: Path, made: dict[str, list[Classified]], up: str) -> None:
    for name, frames in made.items():
        target = folder / "workspace" / "sequences" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        import_frames(
            (each.frame for each in frames), target, RecordingInfo(name, name, 10.0, up=up)
        )


class Annotator:
    """Paints in one frame; ``others`` are only looked at."""

    def __init__(self, api: httpx.Client, kind: str, place: Place, others: list[Place]) -> None:
        self.api, self.place, self.others = api, place, others
        self.xyz = np.asarray(place.made.frame.xyz, np.float64)
        self.truth = place.made.truth.astype(np.int64)
        self.tree, self.radius = cKDTree(self.xyz), RADIUS[kind]
        self.seconds: list[float] = []

    def begin(self, name: str, start_from: Sequence[str]) -> None:
        self.labels = [0]
        for kind in self.place.made.classes:
            where = f"/sequences/{self.place.recording}/labels"
            made = self.api.post(where, json={"name": kind}).raise_for_status().json()
            self.labels.append(made["id"])
        body = {
            "name": name,
            "recordings": [self.place.recording],
            "classes": list(self.place.made.classes),
            "start_from": list(start_from),
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

    def answer(self) -> None:
        """Answer the first doubt with the class of the point in its middle."""
        query = {"classifier": self.classifier, "frame": self.place.frame, "most": 1}
        where = f"/sequences/{self.place.recording}/doubt"
        found = self.api.get(where, params=query).raise_for_status().json()[0]
        label = self.labels[int(self.truth[self.tree.query(found["centre"])[1]])]
        place = {key: found[key] for key in ("frame", "centre", "radius")}
        body = {"classifier": self.classifier, "place": place, "class": label or None}
        self.api.post(f"{where}/answers", json=body).raise_for_status()

    def surprise(self, found: NDArray[np.int64]) -> float:
        """Return by how much the score exceeds the accuracy of the points that are not painted."""
        where = f"/sequences/{self.place.recording}/frames/{self.place.frame}/annotation"
        answer = self.api.get(where, params={"layer": "label"}).raise_for_status()
        open_ = (np.load(io.BytesIO(answer.content)) == 0) & (self.truth > 0)
        taught = self.api.post(f"/classifiers/{self.classifier}/teach", json={"recordings": []})
        score = taught.raise_for_status().json()["score"]
        true = float((found == self.truth)[open_].mean())
        return float("nan") if score is None else score - true

    def run(self, way: str, seed: int) -> dict[int, list[dict[str, float]]]:
        """Scores after so many strokes: there, and in each of the others."""
        rng, reached = np.random.default_rng(seed), {}
        found = np.zeros(len(self.truth), np.int64)
        for number in range(1, max(AT) + 1):
            start = time.perf_counter()
            if way == "doubt" and number > 1:
                self.answer()
            else:
                by_chance = int(rng.integers(len(self.truth)))
                self.stroke(self.worst(found, rng) if way == "worst" else by_chance)
            if way != "random" or number in AT:
                found = self.predict(self.place)
                self.seconds.append(time.perf_counter() - start)
            if number in AT:
                count = len(self.place.made.classes)
                here = scores(self.truth, found, count) | {"expected": self.surprise(found)}
                there = [scores(o.made.truth, self.predict(o), count) for o in self.others]
                reached[number] = [dict(here), *map(dict, there)]
        return reached


def score(
    api: httpx.Client, kind: str, made: Sets, ways: list[str], turns: int | None, start: bool
) -> None:
    """Print a line for each way and number of strokes: mean and worst over what was taught."""
    names = list(made)
    table: dict[tuple[str, int, str], list[dict[str, float]]] = defaultdict(list)
    seconds: list[float] = []
    for turn, name in enumerate(names[:turns]):
        for way in ways:
            others = [Place(name, k, each) for k, each in enumerate(made[name]) if k]
            others += [Place(other, 0, made[other][0]) for other in names if other != name]
            annotator = Annotator(api, kind, Place(name, 0, made[name][0]), others)
            if start:
                for other in others:
                    label_all(api, other)
            annotator.begin(f"{name} {way}", [each for each in names if start and each != name])
            reached = annotator.run(way, turn)
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
        gaps = np.array([f.get("expected", np.nan) for f in found])
        gaps = gaps[np.isfinite(gaps)]  # without those that are not measured yet
        if len(gaps):
            figures += f"  expected {gaps.mean():+.3f} (off by {np.abs(gaps).mean():.3f})"
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


def label_all(api: httpx.Client, place: Place) -> None:
    """Give every point of a frame of another recording its class, as painted earlier."""
    where = f"/sequences/{place.recording}"
    palette = {each["name"]: each["id"] for each in api.get(f"{where}/labels").json()}
    for name in place.made.classes:
        if name not in palette:
            made = api.post(f"{where}/labels", json={"name": name}).raise_for_status().json()
            palette[name] = made["id"]
    table = np.array([0, *(palette[name] for name in place.made.classes)], np.uint16)
    label = table[place.made.truth]
    for layer, values in (("label", label), ("provenance", (label > 0).astype(np.uint8))):
        file = io.BytesIO()
        np.save(file, values)
        path = f"{where}/frames/{place.frame}/annotation"
        api.put(path, params={"layer": layer}, content=file.getvalue()).raise_for_status()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    kinds = ("aerial", "street", "terrain", "room")
    parser.add_argument("--sets", nargs="*", default=list(kinds), choices=kinds)
    parser.add_argument("--ways", nargs="*", default=["worst", "doubt", "random"])
    parser.add_argument("--turns", type=int, help="recordings that are taught in turn, all unless")
    parser.add_argument("--split", choices=("tuning", "checking"), default="checking")
    parser.add_argument("--start", action="store_true", help="start from the other recordings")
    given = parser.parse_args()
    costs()
    for kind in given.sets:
        with tempfile.TemporaryDirectory() as root:
            made = recordings(kind, TUNING if given.split == "tuning" else CHECKING)
            write(Path(root), made, "y" if kind == "room" else "z")
            with serving(Path(root) / "workspace") as api:
                score(api, kind, made, given.ways, given.turns, given.start)


if __name__ == "__main__":
    main()
