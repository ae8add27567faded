"""Vertical axis, stature of people, and heads of touching people.

Touching bodies are separated by the cells beneath each head.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.graph import Paths, paths_into, root_of
from pointbrush.tracking.compute.grid import cells_of
from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.options.people import StatureOptions
from pointbrush.tracking.people.observation import PersonObservation
from pointbrush.tracking.sensors.view import View


def across(view: View, people: Iterable[F64]) -> F64:
    """Return (3, 2) directions along the ground, to the right and ahead of the sensor.

    The vertical is the longest axis of the people (M, 3); if it leans too much, the axis of the
    image's columns is used.
    """
    spread = np.zeros((3, 3))
    for xyz in people:
        offset = xyz - xyz.mean(axis=0)
        spread += offset.T @ offset / len(xyz)
    right, down, ahead = view.T_picture_world[:3, :3]
    up = np.linalg.eigh(spread)[1][:, 2]
    up = up * np.sign(-up @ down)
    if -up @ down < view.options.stature.leaning_cos:
        up = -down
    flat = np.stack([way - (way @ up) * up for way in (right, ahead)], axis=1)
    return np.asarray(flat / np.linalg.norm(flat, axis=0))


def upright(view: View, flat: F64) -> F64:
    """Return the vertical (3,), accurate to a fraction of a degree.

    It is the normal of the level plane with the most points: a floor, table or ceiling.  If there
    is none, it is perpendicular to the directions ``flat`` (3, 2) along the ground.
    Source: consensus (Fischler and Bolles 1981) of planes through small patches.
    """
    options = view.options.stature
    up = np.cross(flat[:, 0], flat[:, 1])
    up = up / np.linalg.norm(up) * -np.sign(up @ view.T_picture_world[1, :3])
    rest = view.xyz[~view.labelled()][:: options.level_stride].astype(np.float64)
    if len(rest) < options.level_points:
        return up
    level = max(_patches(rest, up, options=options), key=len, default=rest[:0])
    for within in options.fit_m:
        if len(level) < options.level_points:
            return up
        normal, spread = _plane(level)
        level = rest[np.abs((rest - level.mean(axis=0)) @ normal) < within]
    return np.asarray(normal * np.sign(normal @ up)) if spread[1] > options.level_sigma_m**2 else up


def _patches(xyz: F64, up: F64, options: StatureOptions) -> Iterable[F64]:
    """Yield the points (N, 3) near the plane of each roughly level patch."""
    patch = cells_of(xyz, options.patch_m)
    count = np.bincount(patch)
    order = np.split(np.argsort(patch, kind="stable"), np.cumsum(count)[:-1])
    for n in np.flatnonzero(count >= max(options.patch_points, float(np.median(count)))).tolist():
        some = xyz[order[n]]
        normal, spread = _plane(some)
        if spread[0] < options.patch_flatness * spread[1] and abs(normal @ up) > options.patch_cos:
            yield xyz[np.abs((xyz - some.mean(axis=0)) @ normal) < options.fit_m[0]]


def _plane(xyz: F64) -> tuple[F64, F64]:
    """Return the normal (3,) of a plane through points (N, 3), and ascending variances (3,)."""
    spread, axes = np.linalg.eigh(np.cov(xyz.T))
    return axes[:, 0], spread


@dataclass(eq=False)
class Stature:
    """Measured ``tops`` of a person, in metres along the vertical from a fixed origin."""

    options: StatureOptions
    tops: list[float] = field(default_factory=list)

    @property
    def known(self) -> bool:
        """Whether there are enough measurements."""
        return len(self.tops) >= self.options.min_tops

    def likelihood(self, top: float) -> float:
        """Return the log density of a measured top over a uniform one in the range.

        It is 0 while the stature is unknown.
        """
        options = self.options
        if not self.known:
            return 0.0
        varies = options.sigma_m * math.sqrt(1 + 1 / len(self.tops))
        deviation = (top - float(np.median(self.tops))) / varies
        upright = math.exp(-0.5 * deviation**2) / (varies * math.sqrt(2 * math.pi))
        return math.log(
            (1 - options.bent_share) * upright * options.bent_range_m + options.bent_share
        )


def ratio(top: float | None, one: Stature, other: Stature) -> float:
    """Return the log likelihood ratio of a top for two statures; 0 without a top."""
    return 0.0 if top is None else one.likelihood(top) - other.likelihood(top)


def top_of(observation: PersonObservation, cells: I64, area: float) -> float | None:
    """Return the height (m) of the top of a person's ``cells`` (C,).

    ``area``: maximum visible surface of the person.  None: the end of the cells may be occluded.
    """
    options = observation.options.stature
    mask = np.zeros(len(observation.owner), np.bool_)
    mask[cells] = True
    points = observation.cells.indices[mask[observation.cells.cell]]
    if not len(points):
        return None
    world = observation.view.xyz[points].astype(np.float64)
    height = world @ observation.up
    depth = observation.view.range_to(world[:: max(1, len(points) // options.sampled_points)])
    above = max(
        1,
        round(
            options.top_share * max(area, observation.area(cells)) / float(np.median(depth)) ** 2
        ),
    )
    if above >= len(points):
        return None
    order = np.argpartition(height, len(points) - above)
    highest = order[len(points) - above :]
    middle = world[highest].mean(axis=0)
    free = observation.view.sees_through(
        middle + np.outer(options.above_m, observation.up), observation.options.body.before_m
    )
    return float(height[highest].min()) if free.all() else None


def beneath_heads(
    observation: PersonObservation, cells: I64, least: float, area: float
) -> list[tuple[I64, I64]]:
    """Return splits of a person's ``cells`` (C,) into two people, in both orders.

    Each part has at least ``least`` cells and a visible top; otherwise the list is empty.
    ``area``: maximum visible surface of the person.
    """
    options = observation.options.body
    some = np.zeros(len(observation.owner), np.bool_)
    some[cells] = True
    links = paths_into(observation.cells.touching, np.ones(len(observation.cells.touching)), some)
    height = observation.cells.middle @ observation.up
    order = cells[np.argsort(-height[cells], kind="stable")]
    head = _peaks(order, links, height, observation.ground, options.head_m)[cells]
    heads, count = np.unique(head, return_counts=True)
    largest = np.argsort(-count, kind="stable")[:2]
    if len(largest) < 2 or count[largest[1]] < least:
        return []
    one, two = (cells[head == heads[n]] for n in largest)
    top, other = (top_of(observation, each, area) for each in (one, two))
    if top is None or other is None or abs(top - other) > options.head_lower_m:
        return []
    gap = np.median(observation.ground[one], axis=0) - np.median(observation.ground[two], axis=0)
    return [(one, two), (two, one)] if np.linalg.norm(gap) > options.heads_apart_m else []


@compiled
def _highest_beside(cell: int, links: Paths, peak: I64, root: I64, height: F64) -> int:
    """Return the highest peak above a neighbour of a cell; -1 if there is none."""
    highest = -1
    for n in range(links.start[cell], links.start[cell + 1]):
        if peak[links.end[n]] >= 0:
            top = root_of(root, peak[links.end[n]])
            if highest < 0 or height[top] > height[highest]:
                highest = top
    return highest


@compiled
def _peaks(order: I64, links: Paths, height: F64, ground: F64, least: float) -> I64:
    """Return (N,) the peak above each of the cells ``order`` (C,), highest first; -1: others.

    A peak that stands out by less than ``least`` metres is merged into the adjacent one.
    """
    peak, root = np.full(len(height), -1), np.arange(len(height))
    for i in order:
        highest = _highest_beside(i, links, peak, root, height)
        if highest < 0:
            peak[i] = i
            continue
        nearest, square = highest, np.sum((ground[i] - ground[highest]) ** 2)
        for n in range(links.start[i], links.start[i + 1]):
            if peak[links.end[n]] >= 0:
                top = root_of(root, peak[links.end[n]])
                if top != highest and height[top] - height[i] < least:
                    root[top] = highest
                elif top != highest:
                    gap = np.sum((ground[i] - ground[top]) ** 2)
                    if gap < square:
                        nearest, square = top, gap
        peak[i] = nearest
    for i in order:
        peak[i] = root_of(root, peak[i])
    return peak
