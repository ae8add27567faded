"""Reading files: points a second per format, beside the usual Python reader of that format.

Seconds are of processor time, so that the figures hold on a busy machine too.

python benchmarks/bench_formats.py [--points 1000000]

The files are synthetic and seeded, except the Kinect recording under ../shared.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
from collections.abc import Callable
from pathlib import Path

import laspy
import numpy as np
from plyfile import PlyData
from pyarrow import csv

from pointbrush.formats import read
from pointbrush.formats.readers.las import read_chunks
from pointbrush.formats.readers.pcd import write_pcd
from pointbrush.formats.readers.ply import write_ply
from pointbrush.formats.readers.text import write_csv
from pointbrush.formats.tables.table import Table

KINECT = Path(__file__).parent.parent.parent / "shared" / "realdata" / "pcl_kinect3"
ROUNDS = 5


def write_files(folder: Path, count: int) -> None:
    """The same cloud in each format."""
    rng = np.random.default_rng(0)
    xyz = rng.normal(scale=3, size=(count, 3)).astype(np.float32)
    columns = {axis: xyz[:, i] for i, axis in enumerate("xyz")}
    colors = {c: rng.integers(0, 256, count, dtype=np.uint8) for c in ("red", "green", "blue")}
    with (folder / "a.ply").open("wb") as file:
        write_ply(file, Table.of(columns | colors))
    with (folder / "a.pcd").open("wb") as file:
        write_pcd(file, Table.of(columns))
    with (folder / "a.csv").open("wb") as file:
        write_csv(file, Table.of(columns | colors))
    np.savez(folder / "a.npz", xyz=xyz, rgb=np.stack(list(colors.values()), axis=1))
    (folder / "a.bin").write_bytes(np.hstack([xyz, rng.random((count, 1))]).astype("<f4").tobytes())
    las = laspy.LasData(laspy.LasHeader(version="1.2", point_format=3))
    las.header.scales = [0.001] * 3
    las.x, las.y, las.z = xyz.astype(float).T
    for color, values in colors.items():
        setattr(las, color, values.astype(np.uint16) * 257)
    las.write(folder / "a.las")
    las.write(folder / "a.laz")


def ours(path: Path) -> int:
    """Points of all frames, those left out too: they were decoded."""
    return sum(len(frame) + frame.dropped for frame in read(path))


def plyfile(path: Path) -> int:
    """The same columns as arrays."""
    vertex = PlyData.read(path)["vertex"]
    np.stack([vertex[name] for name in ("red", "green", "blue")], axis=1)
    return len(np.stack([vertex[name] for name in ("x", "y", "z")], axis=1))


def laspy_read(path: Path) -> int:
    """The same coordinates as float64, and the colours in 8 bits."""
    las = laspy.read(path)
    (np.stack([las.red, las.green, las.blue], axis=1) // 257).astype(np.uint8)
    return len(las.xyz)


def arrow_csv(path: Path) -> int:
    """The same columns by pyarrow, coordinates and colours as arrays."""
    table = csv.read_csv(path)
    np.stack([table[name].to_numpy() for name in ("red", "green", "blue")], axis=1)
    return len(np.stack([table[name].to_numpy() for name in "xyz"], axis=1))


def pypcd4(path: Path) -> int:
    """The same clouds by the fastest PCD reader of PyPI; 0 where it is not installed."""
    try:
        from pypcd4 import PointCloud
    except ImportError:
        return 0
    files = sorted(path.rglob("*.pcd")) if path.is_dir() else [path]
    return sum(len(PointCloud.from_path(file).numpy()) for file in files)


def cpu_seconds() -> float:
    """Processor time of this process, its threads and its ended children."""
    usages = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def rate(run: Callable[[Path], int], path: Path) -> float:
    """Millions of points for each second of processor time, best of some rounds."""
    best, count = float("inf"), 0
    for _ in range(ROUNDS):
        start = cpu_seconds()
        count = run(path)
        best = min(best, cpu_seconds() - start)
    return count / best / 1e6


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=1_000_000)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_files(folder, given.points)
        rows: list[tuple[str, Path, Callable[[Path], int] | None]] = [
            ("PLY, binary", folder / "a.ply", plyfile),
            ("PCD, binary", folder / "a.pcd", pypcd4),
            ("PCD, binary_compressed, Kinect", KINECT, pypcd4),
            ("NPZ", folder / "a.npz", None),
            ("KITTI", folder / "a.bin", None),
            ("LAS", folder / "a.las", laspy_read),
            ("LAZ", folder / "a.laz", laspy_read),
            ("CSV", folder / "a.csv", arrow_csv),
        ]
        print("| format | M points per CPU second | usual reader | ratio |\n|---|---|---|---|")
        for title, path, peer in rows:
            if path.exists():
                mine = rate(ours, path)
                theirs = rate(peer, path) if peer else 0.0
                other = f"{theirs:.1f}" if theirs else ""
                ratio = f"{mine / float(other):.1f}" if other else ""
                label = f"{other} ({peer.__name__})" if peer and other else ""
                print(f"| {title} | {mine:.1f} | {label} | {ratio} |")
        chunks = rate(
            lambda path: sum(len(chunk) for chunk in read_chunks(path, 250_000)), folder / "a.las"
        )
        print(f"| LAS, by chunks of 250 k | {chunks:.1f} | | |")


if __name__ == "__main__":
    main()
