"""Import: a frame of the sample recording step by step, a recording, and a large scan from LAS.

python benchmarks/bench_import.py [--points 5000000] [--keep FOLDER]
python benchmarks/bench_import.py --bytes FILE...

The scan is synthetic and seeded; it is written as LAS (26 bytes a point) and imported by a process
of its own, whose memory is watched.  ``--points 20000000`` is the size of docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import laspy
import numpy as np

from pointbrush.formats import open_source
from pointbrush.samples import generate
from pointbrush.sequences import RecordingInfo, import_frames, import_large, open_sequence
from pointbrush.sequences.columns import encode_frame
from pointbrush.sequences.kdtree import build
from pointbrush.sequences.octree.grid import GridChooser
from pointbrush.sequences.octree.order import morton_order, progressive
from pointbrush.sequences.octree.quantise import ROOM_STEP
from pointbrush.sequences.wire.chunk import Grid, encode_chunk, wire_colors

STATIONS = np.array([[30, 30], [90, 40], [60, 95], [140, 130], [25, 150], [170, 40]], float)
CHUNK = 1_000_000
FRAMES = 60


def town(count: int, rng: np.random.Generator, station: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a town square as one scanner sees it, metres, and their colours."""
    centre = STATIONS[station % len(STATIONS)]
    angle = rng.uniform(0, 2 * np.pi, count)
    reach = rng.uniform(1, 1 + rng.exponential(25, count))
    xyz = np.empty((count, 3))
    xyz[:, :2] = centre + reach[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ground = 2 * np.sin(xyz[:, 0] / 40) + np.cos(xyz[:, 1] / 23)
    xyz[:, 2] = ground
    kind = rng.random(count)
    wall = kind < 0.45  # facades on a grid of streets
    side = rng.integers(0, 2, count)
    index = np.arange(count)
    snapped = np.round(xyz[index, side] / 18) * 18
    xyz[index[wall], side[wall]] = snapped[wall]
    xyz[wall, 2] += rng.uniform(0, 14, int(wall.sum()))
    tree = kind > 0.85
    ball = rng.normal(size=(int(tree.sum()), 3))
    ball *= (2.2 * rng.random(len(ball)) ** 0.3 / np.linalg.norm(ball, axis=1))[:, None]
    xyz[tree, :2] = np.round(xyz[tree, :2] / 9) * 9
    xyz[tree, 2] += 4
    xyz[tree] += ball
    xyz += rng.normal(0, 0.004, xyz.shape)
    rgb = 128 + 70 * np.sin(xyz * [0.7, 0.9, 1.3]) + rng.normal(0, 4, xyz.shape)
    return xyz, np.clip(rgb, 0, 255)


def write_scan(path: Path, points: int) -> None:
    """A LAS file of ``points`` points in millimetres, UTM coordinates, station by station."""
    header = laspy.LasHeader(point_format=2, version="1.2")
    header.scales, header.offsets = np.full(3, 0.001), np.array([448_000.0, 5_411_000.0, 0.0])
    rng = np.random.default_rng(7)
    with laspy.open(path, "w", header=header) as writer:
        for start in range(0, points, CHUNK):
            count = min(CHUNK, points - start)
            xyz, rgb = town(count, rng, start * len(STATIONS) // points)
            rows = laspy.ScaleAwarePointRecord.zeros(count, header=header)
            rows.x, rows.y, rows.z = (xyz + [448_260.0, 5_411_930.0, 310.0]).T
            rows.red, rows.green, rows.blue = (rgb * 257).astype(np.uint16).T
            rows.intensity = 900 + 600 * np.sin(xyz[:, 0]) + rng.normal(0, 40, count)
            writer.write_points(rows)


class Watch:
    """The greatest memory of this process while it lasts, bytes: of its own, and with files."""

    def __init__(self) -> None:
        self.own = self.all = 0
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self) -> None:
        while not self._done.wait(0.05):
            lines = Path("/proc/self/status").read_text().splitlines()
            used = {
                line.split(":")[0]: int(line.split()[1]) << 10 for line in lines if "kB" in line
            }
            self.own = max(self.own, used["RssAnon"] + used["RssShmem"])
            self.all = max(self.all, used["VmRSS"])

    def __enter__(self) -> Watch:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._thread.join()


def import_scan(path: Path, target: Path) -> None:
    """The child's part: import and print the figures."""
    from pointbrush.formats.options import ReadOptions
    from pointbrush.formats.readers.las import read_chunks
    from pointbrush.formats.readers.las_header import read_header

    marks: dict[str, float] = {}
    start = time.perf_counter()

    def mark(_: float, message: str) -> None:
        marks[message.split()[0]] = time.perf_counter() - start

    total = read_header(path, ReadOptions().limits).count
    with Watch() as watch:
        import_large(
            read_chunks(path, CHUNK),
            target,
            RecordingInfo(target.name, "scan"),
            total_points=total,
            progress=mark,
        )
    seconds = time.perf_counter() - start
    used = sum(os.times()[:2])
    print(json.dumps({"seconds": seconds, "cpu": used, "peak": watch.own, "marks": marks}))


def answer(folder: Path, kind: str) -> None:
    """A child's part: read a scan as REST gives it, or export it; print the figures."""
    from pointbrush.settings import Settings
    from pointbrush.web import npy
    from pointbrush.work.exporting import source_columns
    from pointbrush.workspace import Workspace

    class Sink:
        """Counts what a client would get."""

        size = 0

        def write(self, data: bytes) -> int:
            self.size += len(data)
            return len(data)

        def flush(self) -> None:
            """Nothing is kept."""

    workspace = Workspace(Settings(workspace=folder))
    (scan,) = [path.name for path in (folder / "sequences").iterdir()]
    start, out, first = time.perf_counter(), Sink(), 0.0
    with Watch() as watch:
        if kind == "points":
            count = workspace.recording(scan)[0].count
            for piece in npy.stream_points(source_columns(workspace.recording(scan), 0), count)[1]:
                out.write(piece)
                first = first or time.perf_counter() - start
        else:
            workspace.export(scan, kind, out)  # type: ignore[arg-type]
    seconds = time.perf_counter() - start
    workspace.close()
    print(json.dumps({"seconds": seconds, "first": first, "peak": watch.all, "size": out.size}))


def answers(folder: Path) -> None:
    """What it costs to send a whole scan in its source's order."""
    for kind in ("points", "ply", "las"):
        figures = run_child("--answer", str(folder), kind)
        print(
            f"  {kind:7} {figures['size'] / 1e6:7.0f} MB in {figures['seconds']:6.1f} s,", end=" "
        )
        print(f"resident memory at most {figures['peak'] / 2**30:.2f} GiB, files included")


def run_child(*arguments: str) -> dict[str, Any]:
    """The figures that a process of its own prints last."""
    child = subprocess.run(
        [sys.executable, __file__, *arguments], stdout=subprocess.PIPE, text=True, check=True
    )
    figures: dict[str, Any] = json.loads(child.stdout.splitlines()[-1])
    return figures


def large(points: int, folder: Path) -> None:
    """Make, import and probe a scan."""
    path, target = folder / f"scan-{points}.las", folder / "workspace/sequences/scan"
    start = time.perf_counter()
    if not path.exists():
        write_scan(path, points)
    shutil.rmtree(target, ignore_errors=True)
    print(f"scan of {points:,} points, LAS {path.stat().st_size / 1e9:.2f} GB", end=" ")
    print(f"(made in {time.perf_counter() - start:.0f} s)")
    figures = run_child("--import", str(path), str(target))
    seconds = figures["seconds"]
    print(f"  import {seconds:8.1f} s  {points / seconds / 1e6:6.2f} M points/s,", end=" ")
    print(f"{figures['cpu']:.1f} s of processor time")
    print(f"  peak memory {figures['peak'] / 2**30:.2f} GiB (without the page cache)")
    print("  until", {name: round(value, 1) for name, value in figures["marks"].items()})
    probe(target)
    answers(folder / "workspace")


def probe(target: Path) -> None:
    """Sizes, and how long opening and culling take."""
    start = time.perf_counter()
    frame = open_sequence(target)[0]
    first = frame.wire(0, 1)
    opened = time.perf_counter() - start
    table = frame.chunk_table
    wire = int(table["nbytes"].sum()) / frame.count
    disk, fields = (
        sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()) / frame.count
        for folder in (target, target / "fields")
    )
    print(f"  open and read chunk 0 ({len(first):,} bytes) {1e3 * opened:.1f} ms")
    print(f"  {len(table)} chunks, levels {table['level'].min()}..{table['level'].max()},", end=" ")
    print(f"{np.median(table['count']):.0f} points at the median; {frame.blocks.num:,} blocks")
    print(f"  wire {wire:.2f} bytes a point, on disk {disk - fields:.1f}", end=" ")
    print(f"and {fields:.1f} of further fields of the source")
    rng = np.random.default_rng(0)
    centres = frame.coordinates[np.sort(rng.integers(0, frame.count, 50))].astype(np.float64)
    times, found = [], []
    for centre in np.concatenate([centres, centres]):
        start = time.perf_counter()
        blocks = frame.blocks.overlapping(centre - 0.1, centre + 0.1)
        points = np.concatenate(
            [np.arange(frame.blocks.first[b], frame.blocks.first[b + 1]) for b in blocks]
        )
        near = np.linalg.norm(frame.coordinates[points] - centre, axis=1) < 0.1
        times.append(time.perf_counter() - start)
        found.append(int(near.sum()))
    cold, warm = np.array(times[:50]) * 1e3, np.array(times[50:]) * 1e3
    print(f"  ball of 10 cm, {np.median(found):.0f} points: ", end="")
    print(f"first time {np.median(cold):.2f} ms, again {np.median(warm):.2f} ms (median)")


def small() -> None:
    """The steps of one Kinect-like frame, best of five."""
    frame = next(iter(generate("juggling", frames=1).frames))
    xyz = frame.xyz
    order, _ = progressive(morton_order(xyz))
    stored = xyz[order]
    assert frame.rgb is not None
    grid = Grid(np.zeros(3), ROOM_STEP, None)
    colors = wire_colors(frame.rgb[order], None, None, len(xyz))
    encoded, seen = encode_frame(frame, grid), GridChooser()([frame])
    print(f"frame of the sample recording, {len(xyz):,} points, within {encoded.error:.5f} m:")
    print(f"  {len(encoded.wire) / len(xyz):.2f} bytes a point,", end=" ")
    print(f"{decimated(encoded):.2f} in the levels that hold a quarter")
    for name, run in {
        "order": lambda: progressive(morton_order(xyz)),
        "quantise and encode": lambda: encode_chunk(stored, colors, grid),
        "build the k-d tree": lambda: build(stored),
        "all that import does": lambda: encode_frame(frame, grid),
        "the same, depth image too": lambda: encode_frame(frame, seen),
    }.items():
        times = []
        for _ in range(5):
            start = time.perf_counter()
            run()
            times.append(time.perf_counter() - start)
        print(f"  {name:24} {1e3 * min(times):7.1f} ms")


def recording(count: int) -> None:
    """Import a recording of ``count`` frames of a Kinect, made beforehand."""
    made = list(generate("juggling", frames=4).frames)
    frames = [made[number % len(made)] for number in range(count)]
    points = sum(map(len, frames))
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "recording"
        start, used = time.perf_counter(), time.process_time()
        import_frames(frames, target, RecordingInfo("recording", "recording", 30.0))
        seconds, used = time.perf_counter() - start, time.process_time() - used
        disk = sum(file.stat().st_size for file in target.rglob("*") if file.is_file())
    print(f"recording of {count} frames: {count / seconds:.1f} frames/s,", end=" ")
    print(
        f"{1e3 * used / count:.1f} ms of processor time a frame, {disk / points:.1f} bytes a point"
    )


def sizes(paths: list[Path]) -> None:
    """Bytes a point of the first frame of each file or folder, and its greatest error."""
    for path in paths:
        with open_source([path]) as source:
            frame = next(iter(source.frames))
        encoded = encode_frame(frame, GridChooser()([frame]))
        print(f"{path.name:36} {len(frame):8,} points", end=" ")
        points = int(encoded.arrays["chunks"]["nbytes"].sum())
        print(f"{points / len(frame):5.2f} bytes,", end=" ")
        print(f"{decimated(encoded):5.2f} first, {1e3 * encoded.error:.2f} mm", end="")
        if "depth_ends" in encoded.arrays:
            depth = (len(encoded.wire) - points) / len(frame)
            print(f"; depth image {depth:.2f}, colours {encoded.color_error:.1f} of 255", end="")
        print()


def decimated(encoded) -> float:  # type: ignore[no-untyped-def]
    """Bytes a point of the levels that hold a quarter of the points."""
    chunks = encoded.arrays["chunks"]
    part = chunks[chunks["level"] <= max(chunks["level"].max() - 2, 0)]
    return float(part["nbytes"].sum() / part["count"].sum())


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=5_000_000)
    parser.add_argument("--keep", type=Path, help="folder for the scan, kept afterwards")
    parser.add_argument("--import", nargs=2, type=Path, dest="child", help=argparse.SUPPRESS)
    parser.add_argument("--answer", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--bytes", nargs="+", type=Path, help="only the bytes a point of these")
    given = parser.parse_args()
    if given.bytes:
        sizes(given.bytes)
        return
    if given.child:
        import_scan(*given.child)
        return
    if given.answer:
        answer(Path(given.answer[0]), given.answer[1])
        return
    small()
    recording(FRAMES)
    if given.keep:
        given.keep.mkdir(parents=True, exist_ok=True)
        large(given.points, given.keep)
        return
    with tempfile.TemporaryDirectory() as folder:
        large(given.points, Path(folder))


if __name__ == "__main__":
    main()
