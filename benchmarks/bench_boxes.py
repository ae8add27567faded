"""Boxes fitted to labels: 3D IoU with true boxes, beside boxes that end where points end.

    python benchmarks/bench_boxes.py [--seeds 1,2,3] [--frames 20] [--least 20]
                                     [--sustech FOLDER] [--argoverse FOLDER] [--dgp] [--verbose]

Every point of an object is its label's ("perfect paint"). Counted is each frame of an object in
which it has ``--least`` points or more. Printed a source and class: the mean IoU and the share of
at least .7, of the fit, of today's visible box, and of the visible box that is completed to the
class's mean size away from the sensor; of what moves, the share whose direction is within 5
degrees; and how many headings count as known, how many of these are reversed, and how many are
known of those that move over 2 m, or are passed by a moving sensor with poses and have 100 points
in a frame.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from box_scenes import DGP, Case, Floats, argoverse, dgp, generated, sustech

from pointbrush.fitting import BUILT_IN, FittedBox, Observation, fit_box, priors_of
from pointbrush.formats.writers.boxes import upright_box
from pointbrush.geometry.box_overlap import iou_3d
from pointbrush.geometry.quaternions import rotation_of

FAR, MANY = 2.0, 100
"""Metres of motion, and points in a frame, that show the front of a vehicle."""
VEHICLES = ("car", "van", "truck", "bus")


@dataclass(frozen=True, slots=True)
class Row:
    """A frame of an object: IoU of the fit, of the visible box, of one with a fixed prior; degrees
    between the directions; points."""

    source: str
    label: int
    frame: int
    category: str
    moves: bool | None
    fit: float
    visible: float
    fixed: float
    turned: float
    points: int
    known: bool
    passes: bool


def visible(each: Observation) -> tuple[Floats, Floats]:
    """Size and transform of the box round what was seen."""
    box = upright_box(each.xyz, each.up)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = box.R, box.center
    return box.size, T


def completed(each: Observation, category: str) -> tuple[Floats, Floats]:
    """The same with at least the mean size of its class, grown away from the sensor."""
    size, T = visible(each)
    mean = np.array(BUILT_IN[category].mean)
    eye = T[:3, :3].T @ ((np.zeros(3) if each.sensor is None else each.sensor) - T[:3, 3])
    more = np.maximum(mean - size, 0)
    shift = -np.sign(eye) * more / 2 * (np.abs(eye) > size / 2)
    shift[2] = -more[2] / 2
    moved = T.copy()
    moved[:3, 3] += T[:3, :3] @ shift
    return size + more, moved


def measured(case: Case, least: int, made: FittedBox) -> Iterator[Row]:
    """Compare the boxes of an object's frames with the truth."""
    passes = goes_past(case)
    for each in case.observations:
        truth, pose = case.truths.get(each.frame), made.poses.get(each.frame)
        if truth is None or len(each.xyz) < least:
            continue
        T = np.eye(4)
        fit = turned = 0.0
        if pose is not None:
            T[:3, :3], T[:3, 3] = rotation_of(pose.quaternion), pose.centre
            fit = iou_3d(made.size, T, truth.size, truth.T)
            ahead = float(np.clip(T[:3, 0] @ truth.T[:3, 0], -1, 1))
            turned = float(np.degrees(np.arccos(ahead)))
        yield Row(
            case.source, case.label, each.frame, case.category, case.moves, fit,
            iou_3d(*visible(each), truth.size, truth.T),
            iou_3d(*completed(each, case.category), truth.size, truth.T), turned, len(each.xyz),
            made.front_known, passes,
        )  # fmt: skip


def goes_past(case: Case) -> bool:
    """Tell whether motion shows the front: the object or the sensor moves ``FAR`` metres."""
    poses = {each.frame: each.T_world_frame for each in case.observations}
    placed = [(pose, pose @ case.truths[k].T) for k, pose in poses.items()
              if pose is not None and k in case.truths]  # fmt: skip
    if len(placed) < len(case.observations):
        return False
    sensor, own = (
        float(np.linalg.norm(placed[-1][k][:3, 3] - placed[0][k][:3, 3])) for k in range(2)
    )
    seen = max(len(each.xyz) for each in case.observations) >= MANY
    return own > FAR or (sensor > FAR and seen)


def summary(name: str, rows: list[Row]) -> None:
    """Print a line of some rows."""
    if not rows:
        return
    line = f"{name:<22}{len(rows):>6}"
    for key in ("fit", "visible", "fixed"):
        values = np.array([getattr(row, key) for row in rows])
        line += f"{values.mean():>8.3f}{100 * (values >= 0.7).mean():>5.0f} %"
    moved = np.array([row.turned for row in rows if row.moves])
    if len(moved):
        line += f"   {100 * (moved < 5).mean():.1f} % within 5°"
    known = [row for row in rows if row.known]
    past = [row.known for row in rows if row.passes]
    line += f"   known {len(known)}, {sum(row.turned > 120 for row in known)} reversed"
    line += f"; of {len(past)} passed {sum(past)}"
    print(line)


def report(rows: list[Row]) -> None:
    """Print a source's classes."""
    summary("  vehicles", [r for r in rows if r.category in VEHICLES])
    summary("    parked", [r for r in rows if r.category in VEHICLES and r.moves is False])
    summary("    moving", [r for r in rows if r.category in VEHICLES and r.moves])
    for kind in (*VEHICLES, "pedestrian", "cyclist"):
        summary(f"    {kind}", [r for r in rows if r.category == kind])


def run(name: str, cases: Iterable[Case], least: int, verbose: bool) -> None:
    """Fit and report one source."""
    rows: list[Row] = []
    spent, fits, wrong = 0.0, 0, 0
    for case in cases:
        if max(len(each.xyz) for each in case.observations) < least:
            continue
        start = time.process_time()
        made = fit_box(case.observations, priors_of(case.category))
        spent += time.process_time() - start
        fits += 1
        wrong += case.moves is not None and made.moves != case.moves
        found = list(measured(case, least, made))
        rows += found
        if verbose and found:
            mean = np.mean([row.fit for row in found])
            truth = next(iter(case.truths.values())).size.round(2)
            print(
                f"{case.source} {case.label:>3} {case.category:<10} {mean:.2f}"
                f" moves {case.moves} {made.moves} size {made.size.round(2)} true {truth} points"
                f" {found[0].points}..{found[-1].points} turned {found[len(found) // 2].turned:.1f}"
                f" {min(r.turned for r in found):.1f}..{max(r.turned for r in found):.1f}"
            )
    heads = "".join(f"{word:>8}   ≥.7" + " " for word in ("fit", "visible", "fixed"))
    print(f"{name}: {fits} objects, {wrong} taken for moving or still wrongly, {spent:.1f} s")
    print(f"{'':<22}{'boxes':>6}{heads}")
    report(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--least", type=int, default=20)
    parser.add_argument("--sustech", type=Path)
    parser.add_argument("--argoverse", type=Path)
    parser.add_argument("--dgp", action="store_true")
    parser.add_argument("--verbose", action="store_true")
    args = parser.parse_args()
    seeds = [int(seed) for seed in args.seeds.split(",") if seed]
    if seeds:
        made = (case for seed in seeds for case in generated(seed, args.frames))
        run("generated", made, args.least, args.verbose)
    if args.sustech:
        run("SUSTechPOINTS", sustech(args.sustech), args.least, args.verbose)
    if args.argoverse:
        run("Argoverse 2", argoverse(args.argoverse), args.least, args.verbose)
    if args.dgp:
        run("DGP", (case for name in DGP for case in dgp(name)), args.least, args.verbose)


if __name__ == "__main__":
    main()
