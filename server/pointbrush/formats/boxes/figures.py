"""Boxes and marked points of frames in labels of other tools."""

from __future__ import annotations

import logging
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.geometry.oriented_box import Attributes
from pointbrush.names import spelled_out

Floats = NDArray[np.float64]
log = logging.getLogger(__name__)
MOST_NUMBER = 10**9
"""Greatest object number; a key above it is treated as a word."""
GROUND_REACH = 1.0
"""Metres round a box in which its ground is searched."""
GROUND_ABOVE = 0.2
"""Metres above the ground's level that are ground too."""
GROUND_SHARE = 0.1
"""Quantile of the heights round a box that gives the ground's level."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameBox:
    """A box of an object in a frame, in the coordinates of the points.

    ``center`` (3,) and ``size`` (3,) length, width and height, metres; ``rotation`` (3, 3) its
    axes forward, left and up as columns; ``key`` identifies its object in all frames, "" if it is
    unknown; ``label`` is the id of its pointbrush label, 0 for boxes of other tools.
    """

    name: str
    key: str
    center: Floats
    size: Floats
    rotation: Floats
    label: int = 0
    attributes: Attributes = field(default_factory=dict)
    margin: float = 0.0
    """Metres beyond its faces that count as inside, for boxes with rounded numbers."""

    def __post_init__(self) -> None:
        """Write out characters that names must not contain, and compose others."""
        object.__setattr__(self, "name", spelled_out(self.name))

    def moved_back(self, T_boxes_points: Floats) -> FrameBox:
        """Move a box to the coordinates of the points; ``T_boxes_points`` (4, 4)."""
        R, t = T_boxes_points[:3, :3], T_boxes_points[:3, 3]
        return replace(self, center=R.T @ (self.center - t), rotation=R.T @ self.rotation)

    def moved(self, T_new_points: Floats) -> FrameBox:
        """Move a box from the coordinates of the points to others; ``T_new_points`` (4, 4)."""
        R, t = T_new_points[:3, :3], T_new_points[:3, 3]
        return replace(self, center=R @ self.center + t, rotation=R @ self.rotation)

    def scaled(self, scale: float) -> FrameBox:
        """Scale a box about the origin of its coordinates."""
        return replace(self, center=self.center * scale, size=self.size * scale)

    def inside(self, xyz: Floats) -> NDArray[np.bool_]:
        """Mark the points of ``xyz`` (N, 3) that are in the box, its faces included."""
        local = np.abs((xyz - self.center) @ self.rotation)
        return np.asarray((local <= self.size / 2 + self.margin).all(axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class PointFigure:
    """Points of an object: ``rows`` (n,) of the frame's file; ``name`` and ``key`` as of a box.

    ``total``: number of points of that file, 0 if the labels do not state it.
    """

    name: str
    key: str
    rows: NDArray[np.int64]
    label: int = 0
    total: int = 0

    def __post_init__(self) -> None:
        """Write out characters that names must not contain, and compose others."""
        object.__setattr__(self, "name", spelled_out(self.name))


Figure = FrameBox | PointFigure


@dataclass(frozen=True, slots=True, eq=False)
class FrameBoxes:
    """Boxes and marked points of a frame.

    ``frame`` is its index or its name; if it is None, ``time`` (seconds) identifies the frame, or
    the name of the file.  ``numbered``: the index is a number in a whole drive, of which the
    recording may be a part.
    """

    frame: int | str | None
    boxes: tuple[Figure, ...]
    time: float | None = None
    numbered: bool = False

    def moved_back(self, T_boxes_points: Floats) -> FrameBoxes:
        """Move the boxes to the coordinates of the points."""
        return self.changed(lambda box: box.moved_back(T_boxes_points))

    def changed(self, change: Callable[[FrameBox], FrameBox]) -> FrameBoxes:
        """Change the boxes, and leave the marked points as they are."""
        changed = (change(each) if isinstance(each, FrameBox) else each for each in self.boxes)
        return replace(self, boxes=tuple(changed))


def with_one_name(found: Sequence[Sequence[FrameBoxes]]) -> list[list[FrameBoxes]]:
    """Give each object that has several names the most frequent of them, and warn of it.

    A key identifies its object, independent of the class.  Keys that occur twice in a frame, for
    example because each class or file counts separately, keep their names.
    """
    names: dict[str, Counter[str]] = defaultdict(Counter)
    times: Counter[tuple[int | str | None, str]] = Counter()
    for part in (part for file in found for part in file):
        frame = part.frame if part.numbered else id(part)
        times.update((frame, figure.key) for figure in part.boxes)
        for figure in part.boxes:
            names[figure.key][figure.name] += 1
    repeated = {"", *(key for (_, key), count in times.items() if count > 1)}
    several = {k: n for k, n in names.items() if len(n) > 1 and k not in repeated}
    for key, counts in several.items():
        summary = ", ".join(f"{name} in {count} frames" for name, count in counts.most_common())
        log.warning("object %s has several classes and is read as one object: %s", key, summary)
    new = {key: counts.most_common(1)[0][0] for key, counts in several.items()}

    def renamed(part: FrameBoxes) -> FrameBoxes:
        boxes = (replace(each, name=new.get(each.key, each.name)) for each in part.boxes)
        return replace(part, boxes=tuple(boxes))

    return [list(map(renamed, file)) for file in found]


def in_metres(
    found: Sequence[Sequence[FrameBoxes]], scale: float, lo: Floats, hi: Floats
) -> list[list[FrameBoxes]]:
    """Scale boxes that are in the units of a recording's files, ``scale`` metres each.

    They are scaled if this moves more of them between ``lo`` and ``hi`` (3,), the recording's
    bounds.
    """
    boxes = [
        box for file in found for part in file for box in part.boxes if isinstance(box, FrameBox)
    ]
    centers = np.array([box.center for box in boxes]).reshape(-1, 3)
    as_is, scaled = (
        int(((lo <= where) & (where <= hi)).all(axis=1).sum())
        for where in (centers, centers * scale)
    )
    if scaled <= as_is:
        return [list(file) for file in found]
    log.warning("the boxes are in the units of the recording's files: %g m each", scale)
    return [[part.changed(lambda box: box.scaled(scale)) for part in file] for file in found]


def instance_numbers(figures: Iterable[Figure]) -> dict[str, int]:
    """Number the objects of figures by their keys: a numeric key keeps its number, other keys get
    the free numbers in the order of the figures; "" is 0."""
    keys = list(dict.fromkeys(figure.key for figure in figures))
    numbers = {
        key: int(key) for key in keys if key.isascii() and key.isdigit() and 0 < len(key) < 10
    }
    numbers = {key: number for key, number in numbers.items() if 0 < number < MOST_NUMBER}
    taken, free = set(numbers.values()), 1
    for key in keys:
        if key and key not in numbers:
            while free in taken:
                free += 1
            numbers[key] = free
            free += 1
    return numbers | {"": 0}


def points_of(
    boxes: tuple[FrameBox, ...], xyz: Floats, up: Floats, *, no_ground: bool
) -> NDArray[np.int64]:
    """Find the box (N,) of each point, -1 for none; of several boxes, the one with nearer centre.

    ``up`` (3,) points away from the floor; ``no_ground`` leaves out points near the lowest ones
    round a box.
    """
    which = np.full(len(xyz), -1, np.int64)
    nearest = np.full(len(xyz), np.inf)
    for number, box in enumerate(boxes):
        inside = box.inside(xyz)
        if no_ground:
            inside &= ~_ground(box, xyz, up)
        rows = np.flatnonzero(inside)
        distance = np.linalg.norm(xyz[rows] - box.center, axis=1)
        closer = rows[distance < nearest[rows]]
        which[closer], nearest[closer] = number, distance[distance < nearest[rows]]
    return which


def _ground(box: FrameBox, xyz: Floats, up: Floats) -> NDArray[np.bool_]:
    """Mark the points (N,) near the level of the lowest ones round a box."""
    wide = FrameBox(box.name, "", box.center, box.size + 2 * GROUND_REACH, box.rotation)
    height = xyz @ up
    near = wide.inside(xyz) & ~box.inside(xyz)
    if not near.any():
        return np.zeros(len(xyz), np.bool_)
    level = float(np.quantile(height[near], GROUND_SHARE))
    bottom = float(box.center @ up) - float(np.abs(box.rotation.T @ up) @ box.size) / 2
    # Without ground below the box, the lowest points belong to the object.
    if level > bottom + 2 * GROUND_ABOVE:
        return np.zeros(len(xyz), np.bool_)
    return np.asarray(height < level + GROUND_ABOVE)
