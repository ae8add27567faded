"""A classifier applied to one frame of many million points: time and memory.

python benchmarks/bench_example_large.py [--millions 20] [--keep FOLDER]

Generated tiles of land are laid side by side and imported as an octree.  Some balls of one tile are
painted; the classifier labels all else, in a job, as one edit.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.frame import PointFrame
from pointbrush.labels import Write
from pointbrush.labels.types import PAINTED
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.values.classifiers import Application
from pointbrush.workspace import Workspace
from pointbrush_samples.classes import Classified, classified_tile

TILES = 4
EDGE = 130.0
"""Metres from a tile to the next."""
BALLS, RADIUS = 12, 2.0
"""Of a class that are painted, metres."""
NAME = "land"
PATIENCE = 3600.0
"""Seconds."""


def mosaic(millions: float) -> tuple[PointFrame, np.ndarray]:
    """Return tiles side by side in a square, and the class of each point."""
    tiles = [classified_tile(seed) for seed in range(TILES)]
    side = int(np.ceil(np.sqrt(millions * 1e6 / np.mean([len(t.truth) for t in tiles]))))
    places, strengths, truth = [], [], []
    for k in range(side * side):
        tile = tiles[k % TILES]
        xyz = np.asarray(tile.frame.xyz) - np.asarray(tile.frame.xyz).min(axis=0)
        places.append(xyz + [EDGE * (k % side), EDGE * (k // side), 0.0])
        assert tile.frame.intensity is not None
        strengths.append(tile.frame.intensity)
        truth.append(tile.truth)
    frame = PointFrame(np.concatenate(places), intensity=np.concatenate(strengths))
    return frame, np.concatenate(truth)


def prepare(root: Path, millions: float) -> None:
    """Write the recording, and the classes beside it."""
    frame, truth = mosaic(millions)
    target = root / "sequences" / NAME
    target.parent.mkdir(parents=True)
    import_frames(iter([frame]), target, RecordingInfo(NAME, NAME, 1.0, up="z"))
    np.save(root / "truth.npy", truth)


def paint(workspace: Workspace, tile: Classified, truth: np.ndarray) -> None:
    """Paint balls of each class in the first tile."""
    rng = np.random.default_rng(0)
    xyz = np.asarray(tile.frame.xyz, np.float64)
    tree, stored = cKDTree(xyz), workspace.recording(NAME)[0]
    for number, name in enumerate(tile.classes, 1):
        label = workspace.labels.create_label(NAME, "bench", name=name).id
        of_class = np.flatnonzero(truth[: len(xyz)] == number)
        near = tree.query_ball_point(xyz[rng.choice(of_class, BALLS)], RADIUS)
        members = np.unique(np.concatenate(near).astype(np.int64))
        chosen = members[truth[members] == number]
        numbers = np.flatnonzero(np.isin(stored.source_index, chosen))
        workspace.labels.apply(
            NAME, edit_id=None, author="bench", kind="stroke", summary="painted",
            writes={0: Write(numbers, label=label, provenance=PAINTED)},
        )  # fmt: skip


def run(root: Path) -> None:
    """Teach, apply, and print what it took."""
    truth = np.load(root / "truth.npy", mmap_mode="r")
    with closing(Workspace(Settings(workspace=root))) as workspace:
        paint(workspace, classified_tile(0), truth)
        start = time.perf_counter()
        made = workspace.classifiers.create("land", [NAME])
        print(f"taught by {sum(made.examples.values()):,} cells of {made.cell:.2f} m in "
              f"{time.perf_counter() - start:.1f} s", flush=True)  # fmt: skip
        start = time.perf_counter()
        job = workspace.predictions.start(NAME, Application(made.id), "bench")
        ended = workspace.runner.wait(job.id, PATIENCE)
        assert ended.state == "done", ended.error
        took = time.perf_counter() - start
        found = np.asarray(workspace.annotations.read(NAME, 0, "label")[0])
        right = float((found == truth).mean())
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    own = resource.getrusage(resource.RUSAGE_SELF)
    print(f"{len(truth):,} points applied in {took:.0f} s, {right:.3f} of them right")
    print(f"processor's time: worker {spent.ru_utime + spent.ru_stime:.0f} s, server "
          f"{own.ru_utime + own.ru_stime:.0f} s; most memory: worker {spent.ru_maxrss / 2**20:.2f} "
          f"GiB, server {own.ru_maxrss / 2**20:.2f} GiB")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--millions", type=float, default=20.0)
    parser.add_argument(
        "--keep", type=Path, help="folder of the recording, made unless it is there"
    )
    given = parser.parse_args()
    processes = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory() as scratch:
        root = given.keep or Path(scratch)
        if not (root / "truth.npy").exists():
            making = processes.Process(target=prepare, args=(root, given.millions))
            making.start()
            making.join()
            if making.exitcode:
                sys.exit(making.exitcode)
        # Another process: what making took would count as memory of this one.
        running = processes.Process(target=run, args=(root,))
        running.start()
        running.join()
        sys.exit(running.exitcode)


if __name__ == "__main__":
    main()
