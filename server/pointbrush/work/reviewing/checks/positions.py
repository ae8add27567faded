"""Checks of the positions of labels, from a sketch of each frame's labels.

A sketch has the data of a label's points that checks need: the centre, and a piece far from the
rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import Label
from pointbrush.selection.cluster import touching
from pointbrush.values.team.review import Finding
from pointbrush.work.reviewing.checks.finding import CheckOptions, finding, usual_step

F64 = NDArray[np.float64]
Place = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Stray:
    """Points far from their object: their share 0..1, distance in metres, and position."""

    share: float
    distance: float
    place: tuple[float, float, float]


def find_stray(xyz: F64, options: CheckOptions) -> Stray | None:
    """Return the piece of points (N, 3) farthest from the largest piece, or None."""
    from scipy.spatial import cKDTree  # slow to import

    if len(xyz) < 2:
        return None
    nearest = np.asarray(cKDTree(xyz).query(xyz, k=[2])[0])
    piece = pieces(xyz, max(options.link, options.spacing * float(np.median(nearest))))
    sizes = np.bincount(piece)
    if len(sizes) == 1:
        return None
    main = xyz[piece == sizes.argmax()]
    far = max(options.stray, options.stray_extent * float(np.linalg.norm(np.ptp(main, axis=0))))
    others = piece != sizes.argmax()
    distances = cKDTree(main).query(xyz[others])[0]
    # The distance of a piece is that of its nearest point.
    near = np.full(len(sizes), np.inf)
    np.minimum.at(near, piece[others], distances)
    near[sizes.argmax()] = 0.0
    found = np.flatnonzero(near > far)
    if not len(found):
        return None
    worst = found[np.argmax(sizes[found])]
    x, y, z = (float(value) for value in np.median(xyz[piece == worst], axis=0))
    share = float(sizes[found].sum() / len(xyz))
    return Stray(share, float(near[worst]), (x, y, z))


def pieces(xyz: F64, cell: float) -> NDArray[np.int64]:
    """Return the piece (N,) of each point, joined over touching cells of ``cell`` metres."""
    return touching(np.floor(xyz / cell).astype(np.int64))


@dataclass(frozen=True, slots=True)
class Sketch:
    """A label in a frame: its centre in frame and world coordinates, and its stray piece."""

    points: int
    center: Place
    world: Place
    stray: Stray | None


def sketch_frame(
    xyz: NDArray[np.floating],
    label: NDArray[np.uint16],
    pose: F64 | None,
    shift: F64,
    options: CheckOptions,
) -> Mapping[int, Sketch]:
    """Return a sketch of each label above 0.

    ``xyz`` (N, 3) local metres in progressive order, so that the first points of a label are a
    uniform sample of it; ``label`` (N,); ``pose`` ``T_world_frame`` of source coordinates or None;
    ``shift`` (3,) source − local.
    """
    numbers = np.flatnonzero(label)
    order = np.argsort(label[numbers], kind="stable")
    numbers = numbers[order]
    ids, starts = np.unique(label[numbers], return_index=True)
    parts = np.split(numbers, starts[1:]) if len(ids) else []
    found = {}
    for number, part in zip(ids.tolist(), parts, strict=True):
        sample = xyz[part[: options.sample]].astype(np.float64) + shift
        center = np.median(sample, axis=0)
        world = center if pose is None else pose[:3, :3] @ center + pose[:3, 3]
        stray = find_stray(sample, options)
        found[int(number)] = Sketch(len(part), as_place(center), as_place(world), stray)
    return found


def as_place(point: F64) -> Place:
    """Return a point (3,) as plain numbers."""
    x, y, z = (float(value) for value in point)
    return x, y, z


Sketches = Mapping[int, Mapping[int, Sketch]]
"""Sketches by frame and label."""


def stray_points(palette: Sequence[Label], sketches: Sketches) -> Iterator[Finding]:
    """Yield labels with points far from the rest."""
    names = {label.id: label.name for label in palette}
    for frame, labels in sketches.items():
        for label, found in labels.items():
            if found.stray is None or label not in names:
                continue
            points = max(1, round(found.stray.share * found.points))
            text = (
                f"{points:,} {'point' if points == 1 else 'points'} of “{names[label]}” "
                f"{found.stray.distance:.1f} m from the rest"
            )
            yield finding("stray", text, (label,), frame, frame, found.stray.place)


def jumps(palette: Sequence[Label], sketches: Sketches, options: CheckOptions) -> Iterator[Finding]:
    """Yield labels with a centre that moves farther between frames than in neighbouring ones."""
    for label in palette:
        mine = {n: labels[label.id] for n, labels in sketches.items() if label.id in labels}
        steps = {
            frame: float(np.linalg.norm(np.subtract(each.world, mine[frame - 1].world)))
            for frame, each in mine.items()
            if frame - 1 in mine
        }
        for frame, step in steps.items():
            usual = usual_step(steps, frame, options.window)
            if step > max(options.jump, options.jump_factor * usual):
                text = f"“{label.name}” jumps {step:.1f} m from the previous frame"
                yield finding("jump", text, (label.id,), frame, frame, mine[frame].center)
