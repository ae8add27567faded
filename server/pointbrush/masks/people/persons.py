"""People in a depth picture: surfaces of the size of people that the model takes for people."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from pointbrush.masks.people.memory import Memory
from pointbrush.masks.people.motion import Motion
from pointbrush.masks.people.options import PeopleOptions
from pointbrush.masks.people.picture import DepthPicture
from pointbrush.masks.people.segments import Numbers, Surface, connected_surfaces

Floats = NDArray[np.float32]
Mask = NDArray[np.bool_]
SAMPLE = 200
"""Pixels by which the extent of a surface is measured."""
ALL, FIRST, LAST = slice(None), slice(None, -1), slice(1, None)
NEIGHBOURS = (
    ((FIRST, ALL), (LAST, ALL)), ((LAST, ALL), (FIRST, ALL)),
    ((ALL, FIRST), (ALL, LAST)), ((ALL, LAST), (ALL, FIRST)),
)  # fmt: skip
"""Parts of a picture, and the same parts one pixel below, above, right and left."""
Look = Callable[[NDArray[np.uint8]], Floats]
"""The model: a picture (h, w, 3) to the probability (h, w) of a person."""


@dataclass(frozen=True, slots=True, eq=False)
class Person:
    """A person in a picture: ``mask`` (h, w) of its pixels and their mean probability."""

    mask: Mask
    score: float


def find_persons(
    picture: DepthPicture, look: Look, options: PeopleOptions, memory: Memory | None = None,
    motion: Motion | None = None,
) -> list[Person]:  # fmt: skip
    """Return the people in a picture, the nearest first.

    ``memory``: of the frames before, in which the model does not look again at the same surfaces;
    ``motion``: between this frame and others.  People move and furniture rests.
    """
    memory = memory or Memory(options)
    memory.begin_frame()
    surfaces = _surfaces(picture, options, motion)
    found = []
    for group in _groups(surfaces, options)[: options.most_looked]:
        person = _person(picture, group, look, options, memory)
        if person is not None:
            found.append(person)
    return found


def _surfaces(
    picture: DepthPicture, options: PeopleOptions, motion: Motion | None
) -> list[Surface]:
    """Return the surfaces that may belong to people, the nearest first."""
    kept = picture.seen & (picture.room[..., 1] > options.floor)
    gap = (options.gap + options.gap_share * picture.depth).astype(np.float32)
    number = _large(connected_surfaces(picture.xyz, kept, gap), picture, options)
    if motion is not None:
        # Furniture that a moving surface touches is a surface of its own.
        sizes = np.maximum(np.bincount(number.ravel()), 1)
        share = np.bincount(number.ravel(), motion.moved.ravel()) / sizes
        at_rest = motion.rested & (number > 0) & (share[number] >= options.moving_share)
        if at_rest.any():
            apart = np.where(at_rest, options.widest, 0)[..., None].astype(np.float32)
            split = connected_surfaces(picture.xyz + apart, number > 0, gap)
            number = _large(split, picture, options)
    found = []
    for each, place in enumerate(find_objects(number), 1):
        rows, columns = np.nonzero(number[place] == each)
        rows, columns = rows + place[0].start, columns + place[1].start
        surface = _surface(picture, rows, columns, motion)
        width, height, length = (b - a for a, b in zip(surface.low, surface.high, strict=True))
        wide = max(width, length) > options.widest
        if not wide and surface.low[1] < options.overhead and height <= options.tallest:
            found.append(surface)
    return sorted(found, key=lambda surface: surface.depth)


def _large(number: Numbers, picture: DepthPicture, options: PeopleOptions) -> Numbers:
    """Return surfaces (h, w) without surfaces that are too small for a part of a person."""
    sizes = np.bincount(number.ravel(), ((picture.depth * picture.pitch) ** 2).ravel())
    large = sizes >= options.smallest
    large[0] = False
    return np.asarray((np.cumsum(large) * large)[number], np.int32)


def _surface(
    picture: DepthPicture, rows: NDArray[np.int64], columns: NDArray[np.int64],
    motion: Motion | None,
) -> Surface:  # fmt: skip
    some = slice(None, None, max(1, len(rows) // SAMPLE))
    room = picture.room[rows[some], columns[some]]
    ordered, last = np.sort(room, axis=0), len(room) - 1
    low, middle, high = ordered[[last // 100, last // 2, last - last // 100]].tolist()
    depth = float(picture.depth[rows[some], columns[some]].mean())
    area = len(rows) * (depth * picture.pitch) ** 2
    moved = math.nan if motion is None else float(motion.moved[rows, columns].mean())
    return Surface(rows, columns, low, high, middle, depth, area, moved)


def _groups(surfaces: list[Surface], options: PeopleOptions) -> list[list[Surface]]:
    """Return surfaces that stand at one place, the largest of each first."""
    left = sorted(surfaces, key=lambda surface: -len(surface.rows))
    groups: list[list[Surface]] = []
    for surface in left:
        for group in groups:
            if _is_one(group[0], surface, options):
                group.append(surface)
                break
        else:
            least = options.moving_body if _is_moving(surface, options) else options.body
            if surface.area >= least:
                groups.append([surface])
    return groups


def _is_one(body: Surface, other: Surface, options: PeopleOptions) -> bool:
    """Return whether a surface stands where a larger one stands."""
    apart = math.hypot(body.middle[0] - other.middle[0], body.middle[2] - other.middle[2])
    if apart > options.body_apart:
        return False
    gaps = [max(0.0, body.low[k] - other.high[k], other.low[k] - body.high[k]) for k in (0, 2)]
    return math.hypot(*gaps) <= options.gap_between


def _person(
    picture: DepthPicture, group: list[Surface], look: Look, options: PeopleOptions, memory: Memory
) -> Person | None:
    """Return the person that a group of surfaces is, None for other things."""
    moving = _is_moving(group[0], options)
    least = _unusual(group, options) + (options.moving_sure if moving else options.least_sure)
    if least > 1 or not _is_tall(group, options):
        return None
    model = memory.recall(group)
    if model is None:
        model = _chances(picture, group, look, options)
        memory.remember(group, model)
    motion = options.motion_weight * np.array([each.moved for each in group])
    chance = np.fmax(model, motion)
    counts = np.array([len(surface.rows) for surface in group])
    mean = float(chance @ counts / counts.sum())
    parts = [each for each, part in zip(group, chance, strict=True) if part >= options.least_part]
    if mean < least or not _has_size(parts, options) or _floats(parts, picture, options):
        return None
    mask = np.zeros(picture.seen.shape, np.bool_)
    for part in parts:
        mask[part.rows, part.columns] = True
    if moving:
        mask = _without_things(mask, group, picture, look, options)
    return Person(_grown(mask, picture, options), mean)


def _is_tall(group: list[Surface], options: PeopleOptions) -> bool:
    """Return whether a group reaches a person's height, or the picture's upper edge cuts it."""
    least = options.moving_top if _is_moving(group[0], options) else options.top
    return max(surface.high[1] for surface in group) >= least or _is_cut(group)


def _is_moving(surface: Surface, options: PeopleOptions) -> bool:
    return surface.moved >= options.moving_share


def _has_size(group: list[Surface], options: PeopleOptions) -> bool:
    """Return whether surfaces have a person's size together, as far as the picture shows."""
    if not group:
        return False
    low, high = (np.array([getattr(each, end) for each in group]) for end in ("low", "high"))
    width, height, length = high.max(axis=0) - low.min(axis=0)
    widest = min(options.widest, options.widest_share * height)
    fits = height >= options.shortest and max(width, length) <= widest
    return bool(fits and _is_tall(group, options))


def _floats(group: list[Surface], picture: DepthPicture, options: PeopleOptions) -> bool:
    """Return whether a group is in the air: only the background is seen below it."""
    if min(each.low[1] for each in group) < options.lowest:
        return False
    lowest = np.full(picture.seen.shape[1], -1)
    for each in group:
        np.maximum.at(lowest, each.columns, each.rows)
    columns = np.flatnonzero(lowest >= 0)
    rows = lowest[columns]
    below = np.minimum(rows + options.pixels_below, len(picture.seen) - 1)
    behind = picture.depth[below, columns] - picture.depth[rows, columns] > options.background_gap
    return bool(behind.mean() > options.air_share)


def _is_cut(group: list[Surface]) -> bool:
    """Return whether the upper edge of the picture cuts a group."""
    return min(int(each.rows.min()) for each in group) == 0


def _unusual(group: list[Surface], options: PeopleOptions) -> float:
    """Return the probability that shape and rest of a group cost, compared with a usual person."""
    body = group[0]
    width = max(body.high[0] - body.low[0], body.high[2] - body.low[2]) - options.usual_width
    above = max(each.high[1] for each in group) - options.usual_top
    small = math.log(options.usual_area / sum(each.area for each in group))
    return (
        (0.0 if _is_cut(group) else options.top_weight * abs(above))
        + options.width_weight * width
        + options.area_weight * small
        + options.resting_cost * max(0.0, 1 - _moved(group) / options.still_share)
    )


def _moved(group: list[Surface]) -> float:
    """Return the share of pixels of a group that moved, NaN if that is unknown."""
    moved = sum(each.moved * len(each.rows) for each in group)
    return moved / sum(len(each.rows) for each in group)


def _grown(mask: Mask, picture: DepthPicture, options: PeopleOptions) -> Mask:
    """Return a mask (h, w) with the pixels at its outline that are near it in space."""
    free = picture.seen & (picture.room[..., 1] > options.sole)
    for _ in range(options.outline):
        grown = mask.copy()
        for one, other in NEIGHBOURS:
            near = np.abs(picture.depth[one] - picture.depth[other]) <= options.outline_gap
            grown[one] |= mask[other] & free[one] & near
        mask = grown
    return mask


def _chances(
    picture: DepthPicture, group: list[Surface], look: Look, options: PeopleOptions
) -> NDArray[np.float64]:
    """Return the mean probability (n,) of the surfaces of a group.

    The model looks with a small and with a large margin; once, if it is sure.
    """
    looks: list[list[float]] = []
    for margin in options.margins:
        looks.append(_look(picture, group, look, margin))
        if not options.doubt_from <= looks[0][0] <= options.doubt_to:
            break
    return np.asarray(np.mean(looks, axis=0))


def _look(picture: DepthPicture, group: list[Surface], look: Look, margin: float) -> list[float]:
    """Return the mean probability of each surface of a group, in one picture around them."""
    rows, columns = _around(group, picture.seen.shape, margin)
    seen = _probability(picture, (rows, columns), look)
    return [float(seen[s.rows - rows.start, s.columns - columns.start].mean()) for s in group]


def _probability(picture: DepthPicture, place: tuple[slice, slice], look: Look) -> Floats:
    """Return the probability (h, w) by pixel of a part of a picture."""
    seen = look(picture.rgb[place])
    down, right = (
        ((np.arange(each.stop - each.start) + 0.5) * size / (each.stop - each.start)).astype(
            np.intp
        )
        for each, size in zip(place, seen.shape, strict=True)
    )
    return np.asarray(seen[down[:, None], right])


def _without_things(
    mask: Mask, group: list[Surface], picture: DepthPicture, look: Look, options: PeopleOptions
) -> Mask:
    """Return a mask (h, w) without areas of one colour that the model takes for things."""
    place = _around(group, mask.shape, options.margins[0])
    seen, part = _probability(picture, place, look), mask[place]
    step = np.full(part.shape, options.colour_step, np.float32)
    number = connected_surfaces(picture.rgb[place].astype(np.float32), part, step).ravel()
    pixels = np.bincount(number)
    chance = np.bincount(number, seen.ravel()) / np.maximum(pixels, 1)
    area = pixels * (group[0].depth * picture.pitch) ** 2
    thing = (chance < options.thing) & (area >= options.thing_area)
    thing[0] = False
    height = picture.room[place][..., 1].ravel()
    for each in np.flatnonzero(thing):
        low, high = np.quantile(height[number == each], [0.02, 0.98])
        thing[each] = low > options.thing_low and high < options.thing_high
    kept = mask.copy()
    kept[place] &= ~thing[number].reshape(part.shape)
    return kept


def _around(group: list[Surface], shape: tuple[int, ...], margin: float) -> tuple[slice, slice]:
    """Return the square part of a picture around surfaces, as far as the picture goes."""
    spans = [
        (int(min(each.min() for each in ends)), int(max(each.max() for each in ends)) + 1)
        for ends in ([s.rows for s in group], [s.columns for s in group])
    ]
    half = max(stop - start for start, stop in spans) * (1 + margin) / 2
    ends = [
        slice(
            max(0, min(start, round((start + stop) / 2 - half))),
            min(size, max(stop, round((start + stop) / 2 + half))),
        )
        for (start, stop), size in zip(spans, shape, strict=True)
    ]
    return ends[0], ends[1]
