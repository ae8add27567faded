"""People in a depth picture: surfaces of the size of people that the model takes for people."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from pointbrush.masks.people.options import PeopleOptions
from pointbrush.masks.people.picture import DepthPicture
from pointbrush.masks.people.segments import connected_surfaces

Floats = NDArray[np.float32]
Mask = NDArray[np.bool_]
Look = Callable[[NDArray[np.uint8]], Floats]
"""The model: a picture (h, w, 3) to the probability (h, w) of a person."""


@dataclass(frozen=True, slots=True, eq=False)
class Person:
    """A person in a picture: ``mask`` (h, w) of its pixels and their mean probability."""

    mask: Mask
    score: float


@dataclass(frozen=True, slots=True, eq=False)
class _Surface:
    """Pixels of a surface, by row and column, and its extent in the room, metres."""

    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    low: Floats
    high: Floats
    depth: float


def find_persons(picture: DepthPicture, look: Look, options: PeopleOptions) -> list[Person]:
    """Return the people in a picture, the nearest first."""
    surfaces = _surfaces(picture, options)
    found = []
    for group in _groups(surfaces, options)[: options.most_looked]:
        person = _person(picture, group, look, options)
        if person is not None:
            found.append(person)
    return found


def _surfaces(picture: DepthPicture, options: PeopleOptions) -> list[_Surface]:
    """Return the surfaces that may belong to people, the nearest first."""
    kept = picture.seen & (picture.room[..., 1] > options.floor)
    gap = (options.gap + options.gap_share * picture.depth).astype(np.float32)
    number = connected_surfaces(picture.xyz, kept, gap)
    counts = np.bincount(number[kept], minlength=1)
    found = []
    for each, place in enumerate(find_objects(number + 1)):
        if counts[each] < options.least_pixels or place is None:
            continue
        rows, columns = np.nonzero(number[place] == each)
        rows, columns = rows + place[0].start, columns + place[1].start
        room = picture.room[rows, columns]
        low, high = np.quantile(room, (0.01, 0.99), axis=0).astype(np.float32)
        size = high - low
        if max(size[0], size[2]) <= options.widest and size[1] <= options.tallest:
            depth = float(np.median(picture.depth[rows, columns]))
            found.append(_Surface(rows, columns, low, high, depth))
    return sorted(found, key=lambda surface: surface.depth)


def _groups(surfaces: list[_Surface], options: PeopleOptions) -> list[list[_Surface]]:
    """Return surfaces that stand at one place, the largest of each first."""
    left = sorted(surfaces, key=lambda surface: -len(surface.rows))
    groups: list[list[_Surface]] = []
    for surface in left:
        for group in groups:
            if _apart(group[0], surface) <= options.together:
                group.append(surface)
                break
        else:
            groups.append([surface])
    return groups


def _apart(one: _Surface, other: _Surface) -> float:
    """Return the gap between two surfaces in the plan."""
    gaps = np.maximum(one.low, other.low) - np.minimum(one.high, other.high)
    return float(np.hypot(*np.maximum(gaps[[0, 2]], 0.0)))


def _person(
    picture: DepthPicture, group: list[_Surface], look: Look, options: PeopleOptions
) -> Person | None:
    rows, columns = (np.concatenate([getattr(s, n) for s in group]) for n in ("rows", "columns"))
    top = max(surface.high[1] for surface in group)
    low = min(surface.low[1] for surface in group)
    if top - low < options.shortest or (top < options.top and rows.min() > 0):
        return None
    place = _around(rows, columns, picture.seen.shape, options.margin)
    chance = np.zeros(picture.seen.shape, np.float32)
    chance[place] = look(picture.rgb[place])
    mask = np.zeros(picture.seen.shape, np.bool_)
    for surface in group:
        if chance[surface.rows, surface.columns].mean() >= options.part:
            mask[surface.rows, surface.columns] = True
    score = float(chance[mask].mean()) if mask.any() else 0.0
    return Person(mask, score) if score >= options.sure else None


def _around(
    rows: NDArray[np.int64], columns: NDArray[np.int64], shape: tuple[int, ...], margin: float
) -> tuple[slice, slice]:
    """Return the square part of a picture around pixels, as far as the picture goes."""
    spans = [(int(each.min()), int(each.max()) + 1) for each in (rows, columns)]
    half = max(stop - start for start, stop in spans) * (1 + margin) / 2
    ends = [
        slice(max(0, round((start + stop) / 2 - half)), min(size, round((start + stop) / 2 + half)))
        for (start, stop), size in zip(spans, shape, strict=True)
    ]
    return ends[0], ends[1]
