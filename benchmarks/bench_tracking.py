"""Tracking: paint frame 0 with the truth, track to the end without help, compare.

    python benchmarks/bench_tracking.py [--frames 120] [--every 6] [--seeds 1,2] [--draws 3]
                                        [--methods auto,icp]
                                        [--kinds table-top,3-pins,6-pins,walking]
                                        [--seen colourless|turned|noisy|elsewhere|nowhere]
    python benchmarks/bench_tracking.py --kinds street,street-no-poses --frames 15 --methods auto
    python benchmarks/bench_tracking.py --kinds crowd-5hz,crowd-15hz --frames 60 --methods auto
    python benchmarks/bench_tracking.py --real         # lidar scenes in ../shared

Prints for each kind and method: mean IoU over visible object-frames (40 points or more in the
truth); frames until an object's IoU is first under 0.5, the share of objects where that never
happens and the share at 0.5 or more in their last visible frame; CPU milliseconds per object-frame
(one thread), median and p95.  Then calibration: of the frames with confidence over 0.9 the share
with IoU over 0.8, and how many those are; of the frames with IoU under 0.5 the share that is
flagged (lost, occluded or confidence under 0.5), and of those over 0.8 the share flagged for
nothing.  ``--draws N`` tracks each recording N times, but for the first with a micrometre of noise:
what changes then is chance, and so is a change of that size.  ``track_guards.py`` compares two
commits.
Open3D and small_gicp are installed for this benchmark only (tracking_peers.py).
"""

# The thread limits have to be set before numpy is imported.
# ruff: noqa: E402

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
from collections.abc import Callable, Iterator

from tracking_frames import Frame, drawn
from tracking_peers import PEERS, Peer, peer, stay
from tracking_recordings import KINDS, REAL, SCENES, SEEN, recorded
from tracking_score import Score, together

from pointbrush.tracking import METHODS
from pointbrush.tracking.interface import Method

OURS = ("icp", "color-icp", "auto")
ALL = ("nn-copy", *OURS, *PEERS)


def method_named(name: str) -> Callable[[], Method]:
    """What makes a method; raises ImportError for a peer that cannot be had."""
    if name == "nn-copy":
        return lambda: Peer(stay)
    if name in PEERS:
        ready = peer(name)
        return lambda: ready
    return METHODS[name]


def recordings(kind: str, given: argparse.Namespace) -> Iterator[list[Frame]]:
    """One at a time: a recording of 120 frames takes two gigabytes."""
    for seed in [0] if kind in SCENES else map(int, given.seeds.split(",")):
        frames = recorded(kind, seed, given.frames, given.every, given.seen)
        for number in range(given.draws):
            yield drawn(frames, number)


def measure(
    kind: str, given: argparse.Namespace, makers: dict[str, Callable[[], Method]]
) -> dict[str, Score]:
    """The score of each method over all seeds."""
    scores = {name: Score() for name in makers}
    for frames in recordings(kind, given):
        for name, make in makers.items():
            scores[name].run(frames, make())
    return scores


def ready(names: list[str]) -> tuple[dict[str, Callable[[], Method]], dict[str, str]]:
    """The methods that can be measured, and why the others cannot."""
    makers, absent = {}, {}
    for name in names:
        try:
            makers[name] = method_named(name)
        except ImportError as error:
            absent[name] = str(error)
    return makers, absent


def main() -> None:
    """Print the two tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--seeds", default="1,2")
    parser.add_argument("--draws", type=int, default=1)
    parser.add_argument("--methods", default=",".join(ALL))
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--seen", default="camera", choices=SEEN)
    parser.add_argument("--real", action="store_true")
    given = parser.parse_args()
    kinds = given.kinds.split(",")
    if given.real:
        kinds = [scene for scene in SCENES if (REAL / scene).is_dir()]
    makers, absent = ready(given.methods.split(","))
    print("| kind | method | IoU | frames until < 0.5 | never | at the end | ms | p95 |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    scores: dict[str, dict[str, Score]] = {}
    for kind in kinds:
        scores[kind] = measure(kind, given, makers)
        for name, score in scores[kind].items():
            print(f"| {kind} | {name} | {score.quality()} |", flush=True)
        for name, why in absent.items():
            print(f"| {kind} | {name} | not measured: {why} |", flush=True)
    if len(kinds) > 1:
        scores["all"] = {name: together(s[name] for s in scores.values()) for name in makers}
    calibration(scores)


def calibration(scores: dict[str, dict[str, Score]]) -> None:
    """Print the second table, of the methods that have a confidence."""
    rows = [
        f"| {kind} | {name} | {score.calibration()} |"
        for kind, of in scores.items()
        for name, score in of.items()
        if name in OURS
    ]
    if rows:
        print(
            "\n| kind | method | conf > 0.9: IoU > 0.8 | share > 0.9 | IoU < 0.5: flagged", end=""
        )
        print(" | IoU > 0.8: flagged |\n|---|---|---|---|---|---|", *rows, sep="\n")


if __name__ == "__main__":
    main()
