"""Checks of boxes: their motion, their relations, and the points around them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pointbrush.geometry.box_overlap import shared_volume
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.values.team.review import Finding
from pointbrush.work.reviewing.checks.finding import CheckOptions, Kind, finding, usual_step
from pointbrush.work.reviewing.checks.positions import Place, as_place

F64 = NDArray[np.float64]
Names = Mapping[int, str]
"""Names of labels by id."""
LOW = 10.0
"""Percentile of the heights around a box used as its ground, below objects that stand there."""
LEAST_GROUND = 10
"""Minimum number of points for the ground around a box."""
DEEPEST = 3.0
"""Largest distance of the ground below a box, metres."""
HIDDEN = 2
"""Lowest value of ``occluded`` at which a box may have no points."""


@dataclass(frozen=True, slots=True)
class BoxSketch:
    """Relation of a frame's points to its boxes.

    ``empty``    boxes without a point.
    ``above``    height of a box's underside above the ground around it, metres, by box.
    ``outside``  number of a label's points outside its boxes, of all its points, and a position
                 outside; by label.
    """

    empty: frozenset[int] = frozenset()
    above: Mapping[int, float] = field(default_factory=dict)
    outside: Mapping[int, tuple[int, int, Place]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class _ByX:
    """Points ``xyz`` (N, 3), their numbers in the ``order`` (N,) of ``x``, and that (N,)."""

    xyz: F64
    order: NDArray[np.int64]
    x: F64


def sketch_boxes(
    xyz: F64, label: NDArray[np.uint16], boxes: Sequence[OrientedBox], frame: int,
    options: CheckOptions,
) -> BoxSketch:  # fmt: skip
    """Return a sketch of the points ``xyz`` (N, 3), source coordinates, around a frame's boxes.

    ``label`` (N,), 0 also for deleted points.
    """
    empty: set[int] = set()
    above: dict[int, float] = {}
    held = np.zeros(len(xyz), np.bool_)
    order = np.argsort(xyz[:, 0])
    points = _ByX(xyz, order, xyz[order, 0])
    for box in boxes:
        local, near = _near(points, box, box.poses[frame], options)
        half = box.size / 2
        if not (np.abs(local) <= half).all(axis=1).any():
            empty.add(box.id)
        margin = half + options.box_margin
        held[near[(np.abs(local) <= margin).all(axis=1) & (label[near] == box.label)]] = True
        gap = _gap(local[label[near] != box.label], half, options.ground_round)
        if gap is not None:
            above[box.id] = gap
    outside = {}
    every, outer = np.bincount(label), np.bincount(label[~held])
    for number in {box.label for box in boxes if box.label < len(outer)}:
        if outer[number] > max(options.few_points, options.box_outside * every[number]):
            lost = (label == number) & ~held
            place = as_place(np.median(xyz[lost], axis=0))
            outside[number] = (int(outer[number]), int(every[number]), place)
    return BoxSketch(frozenset(empty), above, outside)


def _near(
    points: _ByX, box: OrientedBox, pose: BoxPose, options: CheckOptions
) -> tuple[F64, NDArray[np.int64]]:
    """Return the points around a box in its axes (n, 3), and their numbers (n,)."""
    reach = float(np.linalg.norm(box.size / 2)) + max(options.ground_round, DEEPEST)
    first, last = np.searchsorted(points.x, pose.centre[0] + np.array([-reach, reach]))
    near = points.order[first:last]
    off = points.xyz[near] - pose.centre
    kept = (np.abs(off) <= reach).all(axis=1)
    return off[kept] @ pose.transform[:3, :3], near[kept]


def _gap(local: F64, half: F64, reach: float) -> float | None:
    """Return the height of a box's underside above the ground around it; None: no ground."""
    flat = np.abs(local[:, :2])
    ring = (flat <= half[:2] + reach).all(axis=1) & (flat > half[:2]).any(axis=1)
    heights = local[ring & (local[:, 2] < 0) & (local[:, 2] > -half[2] - DEEPEST), 2]
    return float(-half[2] - np.percentile(heights, LOW)) if len(heights) >= LEAST_GROUND else None


# ── by the boxes alone ───────────────────────────────────────────────────────────────────────


def jumps(
    names: Names, boxes: Sequence[OrientedBox], world: Mapping[int, F64], options: CheckOptions
) -> Iterator[Finding]:
    """Yield frames at which a box moves farther than in neighbouring frames, or reverses.

    ``world``: ``T_world_frame`` of frames with a pose.
    """
    for box in boxes:
        Ts = {f: world.get(f, np.eye(4)) @ pose.transform for f, pose in box.poses.items()}
        steps = {
            frame: float(np.linalg.norm(T[:3, 3] - Ts[frame - 1][:3, 3]))
            for frame, T in Ts.items()
            if frame - 1 in Ts
        }
        for frame, step in steps.items():
            usual = usual_step(steps, frame, options.window)
            cosine = float(Ts[frame][:3, 0] @ Ts[frame - 1][:3, 0])
            turned = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
            change = ""
            if step > max(options.jump, options.jump_factor * usual):
                change = f"jumps {step:.1f} m"
            elif turned > options.box_turn:
                change = f"turns by {turned:.0f}°"
            if change:
                text = f"the box of “{names[box.label]}” {change} from the previous frame"
                yield _finding("box_jump", text, box, frame)


def sizes(names: Names, boxes: Sequence[OrientedBox], options: CheckOptions) -> Iterator[Finding]:
    """Yield boxes of one label with different sizes."""
    first: dict[int, OrientedBox] = {}
    for box in boxes:
        other = first.setdefault(box.label, box)
        off = np.abs(box.size / other.size - 1)
        if off.max() > options.box_size:
            sizes = " and ".join(
                " × ".join(f"{side:.1f}" for side in each.size) + " m" for each in (other, box)
            )
            text = f"boxes of “{names[box.label]}” differ in size: {sizes}"
            yield _finding("box_size", text, box, min(box.poses))


def headings(names: Names, boxes: Sequence[OrientedBox]) -> Iterator[Finding]:
    """Yield boxes with an unknown front."""
    for box in boxes:
        if not box.heading_known:
            text = f"the front of the box of “{names[box.label]}” is unknown"
            yield _finding("box_heading", text, box, min(box.poses))


def overlaps(
    names: Names, boxes: Sequence[OrientedBox], frames: range, options: CheckOptions
) -> Iterator[Finding]:
    """Yield boxes that share much of their volume with another box in a frame."""
    for frame in frames:
        present = [box for box in boxes if frame in box.poses]
        Ts = {box.id: box.poses[frame].transform for box in present}
        for at, one in enumerate(present):
            for two in present[at + 1 :]:
                if _apart(one.size, Ts[one.id], two.size, Ts[two.id]):
                    continue
                smaller = min(float(np.prod(one.size)), float(np.prod(two.size)))
                share = shared_volume(one.size, Ts[one.id], two.size, Ts[two.id]) / smaller
                if share > options.box_overlap:
                    which = f"“{names[one.label]}” and “{names[two.label]}”"
                    text = f"the boxes of {which} overlap by {share:.0%}"
                    yield _finding("box_overlap", text, two, frame, (one.label, two.label))


def _apart(size_a: F64, T_a: F64, size_b: F64, T_b: F64) -> bool:
    """Return whether a plane along a face separates two boxes; False is inconclusive."""
    ways = np.concatenate([T_a[:3, :3], T_b[:3, :3]], axis=1)
    between = np.abs((T_b[:3, 3] - T_a[:3, 3]) @ ways)
    reach_a = size_a / 2 @ np.abs(T_a[:3, :3].T @ ways)
    reach_b = size_b / 2 @ np.abs(T_b[:3, :3].T @ ways)
    return bool((between >= reach_a + reach_b).any())


# ── by the points around them ────────────────────────────────────────────────────────────────


def around(
    names: Names,
    boxes: Sequence[OrientedBox],
    sketches: Mapping[int, BoxSketch],
    options: CheckOptions,
) -> Iterator[Finding]:
    """Yield boxes without points, boxes off the ground, and points of a label outside its box."""
    by_id = {box.id: box for box in boxes}
    for frame, found in sketches.items():
        for number in sorted(found.empty):
            if not _is_hidden(by_id[number], frame):
                text = f"the box of “{names[by_id[number].label]}” holds no points"
                yield _finding("box_empty", text, by_id[number], frame)
        for number, gap in found.above.items():
            if abs(gap) > options.box_hang:
                how = "hangs over" if gap > 0 else "reaches under"
                name = names[by_id[number].label]
                text = f"the box of “{name}” {how} the ground by {abs(gap):.1f} m"
                yield _finding("box_ground", text, by_id[number], frame)
        for label, (lost, every, place) in found.outside.items():
            text = f"{lost:,} of {every:,} points of “{names[label]}” lie outside its box"
            yield finding("box_outside", text, (label,), frame, frame, place)


def _is_hidden(box: OrientedBox, frame: int) -> bool:
    occluded = {**box.attributes, **box.poses[frame].attributes}.get("occluded", 0)
    return isinstance(occluded, int | float) and occluded >= HIDDEN


def _finding(
    kind: Kind, text: str, box: OrientedBox, frame: int, labels: tuple[int, ...] = ()
) -> Finding:
    place = as_place(box.poses[frame].centre)
    return finding(kind, text, labels or (box.label,), frame, frame, place)
