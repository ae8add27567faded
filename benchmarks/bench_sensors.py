"""Several sensors: alignment of their mounts, and tracks of all cameras and of each one alone.

    python benchmarks/bench_sensors.py [--seeds 201,202,203] [--frames 30] [--every 2]
                                       [--grain 0.333] [--only align|track]

Three depth cameras record the generated jugglers (``pointbrush demo --sample stage``).  Alignment
starts from mounts with errors of 2 cm and 2 degrees.  For tracking, frame 0 has the true labels;
``all cameras, its points`` counts the joint run on the points of one camera, beside a run that has
only these.  Objects with 40 points or more count.  ``--grain``: see ``StageOptions``.
"""

# The thread limits have to be set before numpy is imported.
# ruff: noqa: E402

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tracking_frames import LEAST, Frame, Lattice

from pointbrush.samples.sensor import KINECT
from pointbrush.samples.stage import GRAIN, Stage, StageOptions
from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.sensors.alignment import SensorPoints, align_mounts

LATTICE = Lattice(
    KINECT.width,
    KINECT.height,
    axis=2,
    sign=1.0,
    tangent=(-KINECT.cx / KINECT.fx, -KINECT.cy / KINECT.fy),
    pitch=(1 / KINECT.fx, 1 / KINECT.fy),
    eye=(0.0, 0.0, 0.0),
)
ALIGNED_FRAMES = 12
Found = Mapping[int, NDArray[np.int64]]


@dataclass(frozen=True)
class Part:
    """A ``SensorPart`` of a generated camera."""

    sensor: int
    T_frame_sensor: NDArray[np.float64]
    lattice: Lattice = LATTICE


def frame_of(stage: Stage, number: int) -> Frame:
    """A frame of all cameras, with their true mounts."""
    made = stage.frame(number)
    parts = tuple(Part(k, T) for k, T in enumerate(stage.true_mounts))
    truth = stage.truth[number]
    return Frame(made.xyz.astype(np.float32), made.rgb, truth, sensor=made.sensor, parts=parts)


def alone(frame: Frame, camera: int) -> Frame:
    """A frame of one camera, in its own coordinates."""
    T, own = frame.parts[camera].T_frame_sensor, frame.sensor == camera
    xyz = ((frame.xyz[own] - T[:3, 3]) @ T[:3, :3]).astype(np.float32)
    return Frame(xyz, frame.rgb[own], frame.truth[own], np.zeros(3), lattice=LATTICE)


def track(frames: Sequence[Frame]) -> list[Found]:
    """Points by label in each frame, from the truth of the first."""
    first = frames[0].truth
    labels = [n for n in np.unique(first).tolist() if n and np.sum(first == n) >= LEAST]
    seeds = [Seed(n, np.flatnonzero(first == n)) for n in labels]
    run = METHODS["auto"]().track(
        frames.__getitem__, range(len(frames)), seeds, lambda _: None,
        TrackOptions(continue_lost=True),
    )  # fmt: skip
    return [result.assignments for result in run]


def ious(frames: Sequence[Frame], found: Sequence[Found]) -> dict[tuple[int, int], float]:
    """IoU by label and frame."""
    result = {}
    for number, (frame, points) in enumerate(zip(frames, found, strict=True)):
        for label in np.unique(frame.truth).tolist() if number else ():
            own = frame.truth == label
            if label and own.sum() >= LEAST:
                mine = points.get(label, np.empty(0, np.int64))
                both = int(own[mine].sum())
                result[label, number] = both / (own.sum() + len(mine) - both)
    return result


def part_of(frames: Sequence[Frame], found: Sequence[Found], camera: int) -> list[Found]:
    """The points of one camera, in its numbers."""
    result = []
    for frame, points in zip(frames, found, strict=True):
        own = frame.sensor == camera
        number = np.cumsum(own) - 1
        result.append({label: number[each[own[each]]] for label, each in points.items()})
    return result


def show(name: str, scores: Mapping[tuple[int, int], float], people: set[int]) -> None:
    """Print the mean IoU of all objects, of people and of pins, and the least."""
    each = {
        kind: [v for (n, _), v in scores.items() if (n in people) == kind] for kind in (True, False)
    }
    print(
        f"| {name} | {np.mean(list(scores.values())):.3f} | {np.mean(each[True]):.3f} "
        f"| {np.mean(each[False]):.3f} | {min(each[True]):.3f} |", flush=True,
    )  # fmt: skip


def tracks(seed: int, given: argparse.Namespace) -> None:
    """Track the recording of one seed."""
    stage = Stage(seed, given.frames * given.every, StageOptions(grain=given.grain))
    people = {label.id for label in stage.labels if label.category == "person"}
    frames = [frame_of(stage, i * given.every) for i in range(given.frames)]
    joint = track(frames)
    show(f"{seed} all cameras", ious(frames, joint), people)
    for camera, sensor in enumerate(stage.sensors):
        own = [alone(frame, camera) for frame in frames]
        shown = part_of(frames, joint, camera)
        show(f"{seed} all cameras, points of {sensor.name}", ious(own, shown), people)
        show(f"{seed} {sensor.name} alone", ious(own, track(own)), people)


def alignment(seed: int, given: argparse.Namespace) -> None:
    """Correct the mounts of one seed."""
    wrong = StageOptions(3, 0.02, 2.0, given.grain)
    stage = Stage(seed, given.frames * given.every, wrong)
    numbers = np.linspace(0, len(stage) - 1, ALIGNED_FRAMES).astype(int).tolist()
    frames = []
    for number in numbers:
        made: Any = stage.frame(number)
        frames.append([
            SensorPoints(k, stage.mounts[k], made.sensor_xyz[made.sensor == k].astype(float))
            for k in range(len(stage.sensors))
        ])  # fmt: skip
    for k, found in enumerate(align_mounts(frames, [s.name for s in stage.sensors])):
        left = np.linalg.inv(stage.true_mounts[k]) @ stage.mounts[k] @ found.T
        if k:
            rest = replace(found, T=left)
            print(
                f"| {seed} {stage.sensors[k].name} | {1000 * rest.shift:.1f} mm | {rest.turn:.3f}° "
                f"| {1000 * found.before:.1f} mm | {1000 * found.after:.1f} mm |", flush=True,
            )  # fmt: skip


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="201,202,203")
    parser.add_argument("--frames", type=int, default=30)
    parser.add_argument("--every", type=int, default=2)
    parser.add_argument("--grain", type=float, default=GRAIN)
    parser.add_argument("--only", choices=("align", "track"))
    given = parser.parse_args()
    for measure in (alignment, tracks):
        if given.only not in (None, {alignment: "align", tracks: "track"}[measure]):
            continue
        for seed in map(int, given.seeds.split(",")):
            measure(seed, given)


if __name__ == "__main__":
    main()
