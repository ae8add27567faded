"""Objects that the fit of boxes is measured on: their points in each frame, and their true boxes.

Generated traffic; scenes of TRI's DGP beside the checkout; folders of SUSTechPOINTS' example and of
Argoverse 2's logs, where they are given.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting import Observation, near_rays
from pointbrush.formats.boxes.drives import read_argoverse
from pointbrush.formats.boxes.editors import read_sustechpoints
from pointbrush.formats.boxes.figures import FrameBox
from pointbrush.formats.options import Limits, ReadOptions
from pointbrush.formats.readers.feather import argoverse_poses, read_feather, read_table
from pointbrush.formats.readers.pcd import read_pcd
from pointbrush.geometry.quaternions import rotation_of
from pointbrush.sequences.floor import find_floor
from pointbrush_samples.traffic import traffic

Floats = NDArray[np.float64]
REAL = Path(__file__).parent.parent.parent / "shared" / "realdata"
DGP = ("dgp_scene_01", "dgp_scene_02")
REACH = 5.0
"""Metres round an object within which rays are kept."""
SUSTECH_SECONDS = 0.1
"""Seconds for one number of SUSTechPOINTS' frames."""
GROWN = 0.05
"""Metres by which annotated boxes are widened to find their points."""


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """A true box: ``size`` (3,), ``T_frame_box`` (4, 4)."""

    size: Floats
    T: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """An object: its category, whether it ``moves``, what was observed, its boxes by frame."""

    source: str
    label: int
    category: str
    moves: bool | None
    observations: list[Observation]
    truths: dict[int, Truth]


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """A frame: points (n, 3), the label of each, and what an observation wants to know."""

    xyz: Floats
    label: NDArray[np.int64]
    up: Floats
    time: float
    sensor: Floats | None
    pose: Floats | None


def observed(scans: list[Scan], label: int) -> list[Observation]:
    """List what is seen of a label."""
    found = []
    for frame, scan in enumerate(scans):
        own = scan.label == label
        if own.sum() >= 3:
            xyz = scan.xyz[own]
            others = near_rays(xyz, scan.xyz[~own], scan.sensor, scan.up, REACH)
            found.append(
                Observation(frame, xyz, scan.up, scan.time, scan.sensor, scan.pose, others)
            )
    return found


def generated(seed: int, frames: int) -> Iterator[Case]:
    """Make the objects of a seed's traffic, points as the truth has them."""
    made = traffic(seed, frames)
    scans = [
        Scan(
            each.frame.xyz.astype(np.float64), each.instance.astype(np.int64),
            np.array([0.0, 1, 0]), i / 10, np.zeros(3), each.T_room_frame,
        )
        for i, each in enumerate(made.frames)
    ]  # fmt: skip
    for label, box in made.boxes.items():
        observations = observed(scans, label)
        truths = {k: Truth(box.size, pose.transform) for k, pose in box.poses.items()}
        if observations:
            moves = label in made.moving
            yield Case(f"seed {seed}", label, made.kinds[label], moves, observations, truths)


def annotated(
    source: str, frames: list[tuple[Scan, list[FrameBox]]], wanted: dict[str, str]
) -> Iterator[Case]:
    """Make the objects of annotated frames: all points of a box are its label's."""
    keys = sorted({(box.key or f"{k}-{i}") for k, (_, boxes) in enumerate(frames)
                   for i, box in enumerate(boxes) if box.name in wanted})  # fmt: skip
    number = {key: n for n, key in enumerate(keys, 1)}
    scans: list[Scan] = []
    truths: dict[int, dict[int, Truth]] = {}
    kinds: dict[int, str] = {}
    for k, (scan, boxes) in enumerate(frames):
        label = np.zeros(len(scan.xyz), np.int64)
        for i, box in enumerate(boxes):
            if box.name in wanted:
                n = number[box.key or f"{k}-{i}"]
                label[replace(box, size=box.size + GROWN).inside(scan.xyz)] = n
                T = np.eye(4)
                T[:3, :3], T[:3, 3] = box.rotation, box.center
                truths.setdefault(n, {})[k] = Truth(box.size, T)
                kinds[n] = wanted[box.name]
        scans.append(replace(scan, label=label))
    for n, boxes_of in truths.items():
        observations = observed(scans, n)
        if observations:
            yield Case(source, n, kinds[n], _moves(scans, boxes_of), observations, boxes_of)


def _moves(scans: list[Scan], truths: dict[int, Truth]) -> bool | None:
    """Tell whether a true box goes somewhere, where poses are known."""
    poses = [scan.pose for scan in scans]
    if len(truths) < 2:
        return None
    places = []
    for k, truth in truths.items():
        pose = poses[k]
        if pose is None:
            return None
        places.append((pose @ truth.T)[:3, 3])
    return bool(np.linalg.norm(places[-1] - places[0]) > 0.5)


def sustech(folder: Path) -> Iterator[Case]:
    """Read SUSTechPOINTS' example: no poses, a box file for each frame."""
    frames = []
    for path in sorted((folder / "data" / "example" / "lidar").glob("*.pcd")):
        xyz = np.asarray(next(iter(read_pcd(path, ReadOptions()))).xyz, np.float64)
        floor = find_floor(xyz[::10], np.zeros((1, 3)), "survey")
        scan = Scan(
            xyz, np.zeros(len(xyz), np.int64), floor.up, int(path.stem) * SUSTECH_SECONDS,
            np.zeros(3), None,
        )  # fmt: skip
        label = folder / "data" / "example" / "label" / f"{path.stem}.json"
        boxes = [box for each in read_sustechpoints(label) for box in each.boxes]
        frames.append((scan, [box for box in boxes if isinstance(box, FrameBox)]))
    kinds = {
        "Car": "car", "Van": "van", "Truck": "truck", "Bus": "bus", "Pedestrian": "pedestrian",
        "Rider": "cyclist", "Motor": "cyclist",
    }  # fmt: skip
    yield from annotated("sustech", frames, kinds)


ARGOVERSE = {
    "REGULAR_VEHICLE": "car", "LARGE_VEHICLE": "truck", "BUS": "bus", "BOX_TRUCK": "truck",
    "TRUCK": "truck", "PEDESTRIAN": "pedestrian", "BICYCLIST": "cyclist",
    "MOTORCYCLIST": "cyclist", "WHEELED_RIDER": "pedestrian",
}  # fmt: skip


def argoverse(folder: Path) -> Iterator[Case]:
    """Read the logs of Argoverse 2 that have sweeps and annotations."""
    done = set()
    for table in sorted(folder.rglob("annotations.feather")):
        log = table.parent
        sweeps = sorted((log / "sensors" / "lidar").glob("*.feather"))
        if not sweeps or log.name in done:
            continue
        done.add(log.name)
        boxes = {round((each.time or 0) * 1e9 / 1e6): each.boxes for each in read_argoverse(table)}
        times = [int(path.stem) / 1e9 for path in sweeps]
        poses = argoverse_poses(log, times, Limits())
        frames = []
        for k, path in enumerate(sweeps):
            frame: Any = next(iter(read_feather(path, ReadOptions())))
            xyz = np.asarray(frame.xyz, np.float64)
            scan = Scan(
                xyz, np.zeros(len(xyz), np.int64), np.array([0.0, 0, 1]), times[k] - times[0],
                _lidar(log), None if poses is None else np.asarray(poses.matrices[k]),
            )  # fmt: skip
            there = boxes.get(round(int(path.stem) / 1e6), ())
            frames.append((scan, [box for box in there if isinstance(box, FrameBox)]))
        yield from annotated(f"argoverse {log.name[:8]}", frames, ARGOVERSE)


def _lidar(log: Path) -> Floats:
    """Find the place of the upper lidar on the vehicle; its usual place where no file tells."""
    path = log / "calibration" / "egovehicle_SE3_sensor.feather"
    if path.is_file():
        table = read_table(path, Limits(), words=("sensor_name",))
        row = [str(name) for name in table["sensor_name"]].index("up_lidar")
        return np.array([float(table[key][row]) for key in ("tx_m", "ty_m", "tz_m")])
    return np.array([1.35, 0, 1.64])


def dgp(name: str) -> Iterator[Case]:
    """Read a scene of TRI's DGP: three frames with poses."""
    import json

    frames = []
    for k in range(3):
        held = np.load(REAL / name / "npz" / f"{k:04}.npz")
        path = REAL / name / "raw" / f"{k:02}_bounding_box_3d.json"
        boxes = []
        for each in json.loads(path.read_text())["annotations"]:
            b, pose = each["box"], each["box"]["pose"]
            q, t = pose["rotation"], pose["translation"]
            rotation = rotation_of(np.array([q["qx"], q["qy"], q["qz"], q["qw"]]))
            size = np.array([b["length"], b["width"], b["height"]])
            centre = np.array([t["x"], t["y"], t["z"]])
            boxes.append(
                FrameBox(str(each["class_id"]), str(each["instance_id"]), centre, size, rotation)
            )
        xyz = held["xyz"].astype(np.float64)
        floor = find_floor(xyz[::5], np.zeros((1, 3)), "survey")
        pose = held["pose"].astype(np.float64)
        scan = Scan(xyz, np.zeros(len(xyz), np.int64), floor.up, k / 10, np.zeros(3), pose)
        frames.append((scan, boxes))
    yield from annotated(name, frames, {"1": "pedestrian", "2": "car", "3": "truck"})
