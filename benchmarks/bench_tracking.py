"""Tracking: paint frame 0 with the truth, track to the end without help, compare.

    python benchmarks/bench_tracking.py [--frames 60] [--seeds 1,2] [--methods auto,icp] [--real]
                                        [--ablation] [--kinds tabletop,3-pins,6-pins,walking]

Prints one row per kind and method: mean IoU over visible object-frames (40 points or more), share
of objects alive (IoU 0.5 or more) in their last visible frame, CPU milliseconds per object-frame
(median and p95, one thread), and calibration: share of frames with confidence over 0.9 that have
IoU over 0.8, and share of frames with IoU under 0.5 that are flagged.  Open3D's ICPs and
small_gicp's GICP are compared where they can be imported.
"""

# The thread limits have to be set before numpy is imported.
# ruff: noqa: E402, ARG002

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from unittest.mock import patch

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.samples import generate
from pointbrush.tracking import METHODS, FrameResult, Seed, TrackOptions, TrackState, auto
from pointbrush.tracking.paper import _cut, _Object, _painted
from pointbrush.tracking.registration import transform

REAL = Path(__file__).parent.parent.parent / "shared" / "realdata"
LEAST = 40
KINDS = {
    "table-top": ("tabletop", {}),
    "3-pins": ("juggling", {"people": 1, "pins": 3, "label_people": False}),
    "6-pins": ("juggling", {"pins": 6, "label_people": False, "like_clothes": True}),
    "walking": ("walking", {}),
}


@dataclass(eq=False)
class Frame:
    xyz: np.ndarray
    rgb: np.ndarray | None
    truth: np.ndarray
    viewpoint: np.ndarray | None = None
    pose: np.ndarray | None = None
    intensity: np.ndarray | None = None

    @cached_property
    def kdtree(self) -> cKDTree:
        return cKDTree(self.xyz, balanced_tree=False)


@dataclass
class Other:
    """Frame-to-frame tracking with another registration: (source, target) -> 4x4."""

    register: Callable[[_Object, Frame], np.ndarray]

    def track(self, frames, order, seeds, known, options) -> Iterator[FrameResult]:
        first = frames(order[0])
        things = {s.label: _cut(first, s.indices, np.eye(4)) for s in seeds}
        yield FrameResult(
            order[0], {}, {s.label: _painted(len(s.indices), np.eye(4)) for s in seeds}
        )
        for number in order[1:]:
            frame, found, tracks = frames(number), {}, {}
            for label, thing in things.items():
                T = self.register(thing, frame)
                near = frame.kdtree.query_ball_point(transform(T, thing.xyz), 1.2 * thing.spacing)
                points = np.unique(np.concatenate([np.asarray(n, np.int64) for n in near]))
                found[label] = points
                inliers = float(np.mean([len(n) > 0 for n in near]))
                tracks[label] = TrackState(T, 0.0, inliers, inliers, len(points), "tracked")
                if len(points):
                    things[label] = _cut(frame, points, T @ thing.pose)
            yield FrameResult(number, found, tracks)


def others() -> dict[str, Callable[[], Other]]:
    found: dict[str, Callable[[], Other]] = {"nn-copy": lambda: Other(lambda *_: np.eye(4))}
    try:
        import small_gicp  # type: ignore[import-not-found]

        def gicp(thing: _Object, frame: Frame) -> np.ndarray:
            fit = small_gicp.align(
                frame.xyz.astype(np.float64), thing.xyz, downsampling_resolution=thing.spacing
            )
            return fit.T_target_source

        found["small_gicp"] = lambda: Other(gicp)
    except ImportError:
        pass
    try:
        import open3d as o3d  # type: ignore[import-not-found]

        def cloud(xyz: np.ndarray, rgb: np.ndarray):
            c = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(xyz.astype(np.float64)))
            c.colors = o3d.utility.Vector3dVector(rgb / 255.0)
            c.estimate_normals()
            return c

        def open3d(thing: _Object, frame: Frame, coloured: bool) -> np.ndarray:
            r = o3d.pipelines.registration
            a, b = cloud(thing.xyz, thing.colour), cloud(frame.xyz, frame.rgb)
            if coloured:
                return r.registration_colored_icp(a, b, 0.1).transformation
            return r.registration_icp(a, b, 0.3).transformation

        found["open3d-icp"] = lambda: Other(lambda t, f: open3d(t, f, False))
        found["open3d-color"] = lambda: Other(lambda t, f: open3d(t, f, True))
    except ImportError:
        pass
    return found


@dataclass
class Score:
    iou: list[float] = field(default_factory=list)
    confidence: list[float] = field(default_factory=list)
    flagged: list[bool] = field(default_factory=list)
    alive: list[bool] = field(default_factory=list)
    ms: list[float] = field(default_factory=list)

    def row(self, kind: str, method: str) -> str:
        iou, conf = np.array(self.iou), np.array(self.confidence)
        bad, sure = iou < 0.5, conf > 0.9
        good = f"{np.mean(iou[sure] > 0.8):.2f}" if sure.any() else "-"
        flagged = f"{np.mean(np.array(self.flagged)[bad]):.2f}" if bad.any() else "-"
        return (
            f"| {kind} | {method} | {iou.mean():.3f} | {np.mean(self.alive):.2f} "
            f"| {np.median(self.ms):.0f} | {np.percentile(self.ms, 95):.0f} | {good} | {flagged} |"
        )


def run(frames: Sequence[Frame], method: object, score: Score) -> None:
    first = frames[0].truth
    labels = [n for n in np.unique(first).tolist() if n and np.sum(first == n) >= LEAST]
    seeds = [Seed(n, np.flatnonzero(first == n)) for n in labels]
    last: dict[int, float] = {}
    options = TrackOptions(continue_lost=True)
    order = range(len(frames))
    clock = time.process_time()
    for result in method.track(frames.__getitem__, order, seeds, lambda _: None, options):
        spent = time.process_time() - clock
        if result.frame:
            score.ms.append(1e3 * spent / len(labels))
            for label in labels:
                truth = frames[result.frame].truth == label
                if truth.sum() < LEAST:
                    continue
                points = result.assignments.get(label, np.empty(0, np.int64))
                both = truth[points].sum()
                iou = float(both / (truth.sum() + len(points) - both))
                track = result.tracks.get(label)
                score.iou.append(iou)
                score.confidence.append(track.confidence if track else 0.0)
                score.flagged.append(
                    track is None or track.state in ("lost", "occluded") or track.confidence < 0.5
                )
                last[label] = iou
        clock = time.process_time()
    score.alive += [value >= 0.5 for value in last.values()]


def generated(kind: str, seed: int, count: int) -> list[Frame]:
    name, options = KINDS[kind]
    rec = generate(name, seed, count, **options)
    return [
        Frame(f.xyz.astype(np.float32), f.rgb, rec.truth[i], f.viewpoint)
        for i, f in enumerate(rec.frames)
    ]


def real(scene: str) -> list[Frame]:
    frames = []
    for path in sorted((REAL / scene / "npz").glob("*.npz")):
        d = np.load(path)
        frames.append(Frame(d["xyz"], d["rgb"], d["instance"].astype(np.uint16), None, d["pose"]))
    return frames


def without(what: str):
    """``auto`` with one idea taken out."""
    none = np.empty(0, np.int64)
    locate = auto.Run.__module__.replace(".auto", ".locate")
    change: dict[str, tuple[str, object]] = {
        "motion": (
            "pointbrush.tracking.motion.Motion.predictions",
            lambda self: [self.poses[-1]],
        ),
        "background": (
            "pointbrush.tracking.background.ImageBackground.static",
            lambda _s, _v, i: (np.zeros(len(i), bool), np.zeros(len(i), bool)),
        ),
        "sharing out": ("pointbrush.tracking.auto.share_out", lambda _s: None),
        "other guesses": (f"{locate}.proposals", lambda *_: []),
        "growing": ("pointbrush.tracking.auto.grow", lambda *_: {}),
        "model over frames": ("pointbrush.tracking.model.Model.gather", lambda *_: None),
        "rivals": (
            "pointbrush.tracking.belong.contested",
            lambda _v, found, _r: np.zeros(len(found.indices), bool),
        ),
        "slow-only keeping": ("pointbrush.tracking.auto.Run._shadow", lambda *_: none),
    }
    return change if what == "" else patch(*change[what])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--seeds", default="1,2")
    parser.add_argument("--methods", default="")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--real", action="store_true")
    parser.add_argument("--ablation", action="store_true")
    args = parser.parse_args()
    known = {**others(), **{n: METHODS[n] for n in ("icp", "color-icp", "auto")}}
    names = args.methods.split(",") if args.methods else list(known)
    recordings: dict[str, list[list[Frame]]] = {}
    if args.real:
        recordings = {s: [real(s)] for s in ("dgp_scene_01", "dgp_scene_02") if REAL.is_dir()}
    else:
        for kind in args.kinds.split(","):
            recordings[kind] = [generated(kind, int(s), args.frames) for s in args.seeds.split(",")]
    for frames in (f for recs in recordings.values() for rec in recs for f in rec):
        _ = frames.kdtree  # stored with a recording, so not part of the cost
    print("| kind | method | IoU | survival | ms | p95 | conf > 0.9 good | bad flagged |")
    print("|---|---|---|---|---|---|---|---|")
    for kind, recs in recordings.items():
        cases = [(n, known[n], None) for n in names]
        if args.ablation:
            cases = [("auto", known["auto"], None)]
            cases += [(f"without {w}", known["auto"], w) for w in without("")]
        for name, factory, left_out in cases:
            score = Score()
            for frames in recs:
                if left_out:
                    with without(left_out):
                        run(frames, factory(), score)
                else:
                    run(frames, factory(), score)
            print(score.row(kind, name), flush=True)


if __name__ == "__main__":
    main()
