"""Strides of people, and the probability of a cell to be theirs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.graph import agreed, parts
from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.compute.rigid import carried
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options.people import StrideOptions
from pointbrush.tracking.people.observation import PersonObservation
from pointbrush.tracking.people.person import Person
from pointbrush.tracking.sensors.camera import I32, Pixels, pixel

GRID = (np.arange(13) - 6) / 2
"""Candidate offsets along each axis, in standard deviations."""


class Picture(NamedTuple):
    """Depth image of a frame for compiled loops.

    ``depth`` (cells + 1,); ``loose`` (cells + 1,): pixels available to people; ``point``
    (cells + 1,): index into the colours ``tints`` (M, 3), which are empty without colour.
    """

    lens: Pixels
    T_lens_world: F64
    depth: F32
    loose: Mask
    point: I32
    tints: F32


class PixelCosts(NamedTuple):
    """Costs of a pixel, and the distances of depth and colour they apply to: ``StrideOptions``."""

    same_depth_m: np.float32
    hidden: float
    unknown: float
    depth_weight: float
    colour_weight: np.float32
    other_colour: np.float32


def strides(observation: PersonObservation, people: Sequence[Person]) -> F64:
    """Return (K, 3) the stride of each person in metres."""
    view, cells = observation.view, observation.cells
    point = np.full(len(view.depth), -1, np.int32)
    point[view.cells.cell[cells.indices]] = np.arange(len(cells.indices), dtype=np.int32)
    tints = np.empty((0, 3), np.float32) if observation.tints is None else observation.tints
    loose = view.marked(cells.indices)
    pictures = [
        Picture(sight.lens.pixels, view.T_lens_world, view.depth, loose, point, tints)
        for sight in view.sights
        if sight.lens is not None
    ]
    depth = [float(np.median(view.range_to(f.xyz))) for f in people]
    found = np.zeros((len(people), 3))
    for k in sorted(range(len(people)), key=lambda k: (people[k].frames_unseen > 0, depth[k])):
        found[k] = _stride(observation, people[k], pictures)
        reach = observation.options.step.own_cells * cells.size
        own = close_to(cells.middle, people[k].xyz + found[k], reach)[cells.cell]
        loose[view.cells.cell[cells.indices[own]]] = False
    return found


def _stride(observation: PersonObservation, person: Person, pictures: Sequence[Picture]) -> F64:
    options = observation.options.step
    varies = options.stride_m + options.stride_share * float(np.linalg.norm(person.step))
    varies += options.stride_m_per_frame * min(person.frames_unseen, options.max_unseen_frames)
    right, ahead = (axis.ravel() for axis in np.meshgrid(GRID, GRID))
    tried = person.step + varies * (
        right[:, None] * observation.flat[:, 0] + ahead[:, None] * observation.flat[:, 1]
    )
    some = slice(None, None, max(1, len(person.xyz) // options.sampled_cells))
    # Always contiguous, so that the loop is compiled for one layout.
    xyz, colour = np.ascontiguousarray(person.xyz[some]), np.ascontiguousarray(person.colour[some])
    costs = PixelCosts(
        np.float32(options.same_depth_m),
        options.hidden_cost,
        options.unknown_cost,
        options.depth_weight,
        np.float32(options.colour_weight),
        np.float32(options.other_colour),
    )
    nearest_m = observation.options.lens.nearest_m
    cost = sum(_mean_costs(each, xyz, colour, tried, costs, nearest_m) for each in pictures)
    total = options.evidence_weight * cost + (right**2 + ahead**2) / 2
    return np.asarray(tried[total.argmin()])


@compiled
def _mean_costs(
    picture: Picture, xyz: F64, colour: F32, tried: F64, costs: PixelCosts, nearest_m: float
) -> F64:
    """Return (T,) mean pixel costs of the surface (M, 3) moved by the steps ``tried`` (T, 3)."""
    result = np.zeros(len(tried))
    for t in range(len(tried)):
        for i in range(len(xyz)):
            x, y, z = xyz[i, 0] + tried[t, 0], xyz[i, 1] + tried[t, 1], xyz[i, 2] + tried[t, 2]
            x, y, z = carried(picture.T_lens_world, x, y, z)
            at = (float(np.float32(x)), float(np.float32(y)), float(np.float32(z)))
            cell, depth = pixel(picture.lens, at, nearest_m)
            result[t] += _cost(picture, cell, np.float32(depth), colour[i], costs)
    return result / len(xyz)


@compiled
def _cost(picture: Picture, cell: int, depth: np.float32, colour: F32, costs: PixelCosts) -> float:
    """Return the cost of surface of a ``colour`` (3,) at a ``depth`` of a ``cell``."""
    if cell < 0:
        return costs.hidden
    if np.isnan(picture.depth[cell]):
        return costs.unknown
    behind = picture.depth[cell] - depth
    if not abs(behind) <= costs.same_depth_m:
        return 1.0 if behind > costs.same_depth_m else costs.hidden
    if not picture.loose[cell]:
        return 1.0
    cost = 0.5 * float(behind / costs.same_depth_m) ** 2
    if not len(picture.tints):
        return cost
    tint, square = picture.tints[picture.point[cell]], np.float32(0.0)
    for a in range(3):
        square += (tint[a] - colour[a]) ** 2
    unlike = np.sqrt(square) / costs.other_colour
    other = costs.colour_weight * min(np.float32(1.0), unlike * unlike)
    return costs.depth_weight * cost + float(other)


@dataclass(frozen=True, slots=True, eq=False)
class Shares:
    """``stride`` (K, 3): metres of each person; ``cost`` (N, K): cost of a cell to be theirs."""

    stride: F64
    cost: F64

    def disputed(self, cells: I64, person: int, options: StrideOptions) -> float:
        """Return the share of a person's cells with a nearly equal cost for another person."""
        others = np.delete(self.cost[cells], person, axis=1)
        if not others.shape[1] or not len(cells):
            return 0.0
        return float((others.min(axis=1) < self.cost[cells, person] + options.disputed_cost).mean())


def shared_out(observation: PersonObservation, people: Sequence[Person], stride: F64) -> Shares:
    """Assign owners to the cells of an ``observation``, and refine the strides (K, 3) by them."""
    options = observation.options.step
    clothes = _clothes(observation, people)
    steps = [float(np.linalg.norm(f.step)) for f in people if not f.frames_unseen]
    swing = options.limbs_m + options.swing_share * min(
        max([options.slowest_m, *steps]), options.fastest_m
    )
    stride = stride.copy()
    surfaces = [_Surface.of(f, swing, coloured=observation.tints is not None) for f in people]
    for _ in range(options.rounds):
        cost = np.full((len(observation.owner), len(people)), options.cap)
        near = []
        for k, surface in enumerate(surfaces):
            cost[:, k], nearest = _surface_costs(observation, surface, stride[k])
            near.append(nearest)
        cost += clothes
        chance = agreed(
            cost,
            observation.links,
            observation.view.options.mean_field.sweeps,
            observation.view.options.mean_field.settled_change,
            observation.view.options.mean_field.same_change,
            observation.view.options.mean_field.neighbour_weight,
            observation.view.options.mean_field.full_neighbours,
        )
        likeliest = chance.argmax(axis=1)
        mended = np.zeros_like(stride)
        for k, person in enumerate(people):
            cells = np.where(likeliest == k, near[k], -1)
            mended[k] = _mended(observation, person, stride[k], chance[:, k], cells, swing)
        stride += mended
        if np.linalg.norm(mended, axis=1).max() < options.settled_m:
            break
    observation.owner = np.array([f.label for f in people], np.int64)[likeliest]
    _leave(observation, cost.min(axis=1), chance.max(axis=1))
    for k, person in enumerate(people):
        _drop(observation, person, stride[k])
    return Shares(stride, cost)


def _clothes(observation: PersonObservation, people: Sequence[Person]) -> F64:
    """Return (N, K) colour costs of each cell."""
    options = observation.options.step
    cost = np.zeros((len(observation.owner), len(people)))
    for k, person in enumerate(people):
        if observation.tints is not None and person.identity.appearance is not None:
            rare = (
                person.identity.appearance.usual
                - options.clothes_rarer_log
                - person.identity.appearance.each(observation.tints)
            )
            cost[:, k] = options.clothes_weight * observation.mean(
                np.clip(rare, 0.0, options.clothes_max_log)
            )
    return cost


@dataclass(frozen=True, eq=False)
class _Surface:
    """A person's surface in the last frame, with a search tree in units of ``within`` metres."""

    person: Person
    within: float
    own: F64
    tree: cKDTree

    @staticmethod
    def of(person: Person, swing: float, *, coloured: bool) -> _Surface:
        options = person.options.step
        within = swing + options.limbs_m_per_frame * min(
            person.frames_unseen, person.options.search.max_growing_frames
        )
        own = person.xyz / within
        if coloured:
            own = np.hstack([own, person.colour / options.shade])
        return _Surface(person, within, own, cKDTree(own))


def _surface_costs(
    observation: PersonObservation, surface: _Surface, stride: F64
) -> tuple[F64, I64]:
    """Return (N,) the cost of each cell to be theirs, and its nearest surface point; -1: none."""
    options = observation.options.step
    own, person = surface.own, surface.person
    seen = (observation.cells.middle - stride) / surface.within
    if own.shape[1] > seen.shape[1]:
        seen = np.hstack([seen, observation.cells.colour / options.shade])
    reach = np.sqrt(2 * options.cap)
    close = np.all((seen > own.min(axis=0) - reach) & (seen < own.max(axis=0) + reach), axis=1)
    gap, near = np.full(len(seen), np.inf), np.full(len(seen), -1)
    gap[close], near[close] = surface.tree.query(seen[close], distance_upper_bound=reach)
    cost = np.where(np.isfinite(gap), 0.5 * np.minimum(gap, options.cap) ** 2, options.cap)
    middle = np.median((person.xyz + stride) @ observation.flat, axis=0)
    distance = np.linalg.norm(observation.ground - middle, axis=1)
    cost += np.minimum(
        options.body_max_cost,
        0.5 * (np.maximum(0.0, distance - options.body_m) / options.body_sigma_m) ** 2,
    )
    cost += options.hidden_cost_owner * (person.frames_unseen > 0)
    return cost, np.where(np.isfinite(gap), near, -1).astype(np.int64)


def _mended(
    observation: PersonObservation,
    person: Person,
    stride: F64,
    chance: F64,
    near: I64,
    swing: float,
) -> F64:
    """Return the correction (3,) of a stride, by a person's cells and expected visible surface.

    ``near`` (N,): nearest surface point of each of their cells, -1 for other cells; ``chance``
    (N,): probability of each to be theirs; ``swing``: metres of motion of limbs.
    """
    options = observation.options
    cells = np.flatnonzero((near >= 0) & observation.cells.solid)
    if len(cells) < max(options.body.seen_min_cells, options.step.corrected_share * person.size):
        return np.zeros(3)
    there = person.xyz + stride
    seen = observation.cells.middle[cells]
    weight = chance[cells] * np.sqrt(observation.cells.count[cells])
    off = ((seen - there[near[cells]]) * weight[:, None]).sum(axis=0) / weight.sum()
    shown = observation.shows(there)
    gap, nearest = map(
        np.asarray, cKDTree(seen).query(there[shown], 1, 0, 2, options.step.met_swings * swing)
    )
    met = np.isfinite(gap)
    if np.count_nonzero(met) > options.body.seen_min_cells:
        off = (off + (seen[nearest[met]] - there[shown][met]).mean(axis=0)) / 2
    share = float(shown.mean())
    return np.asarray(off * share / (share + options.step.visible_doubt))


def _leave(observation: PersonObservation, cost: F64, chance: F64) -> None:
    """Release the bodies and cells that fit no person well."""
    options = observation.options.step
    inside = observation.bodies >= 0
    explained = cost < options.fitting_cap_share * options.cap
    if inside.any():
        body = observation.bodies[inside]
        bad = np.bincount(
            body, weights=explained[inside]
        ) < options.fitting_cells_share * np.bincount(body)
        observation.owner[inside] = np.where(bad[body], 0, observation.owner[inside])
    observation.owner[~inside & ~explained & (chance <= options.sure_probability)] = 0


def _drop(observation: PersonObservation, person: Person, stride: F64) -> None:
    """Release parts of a person that are disconnected and away from the expected position."""
    options = observation.options
    cells = np.flatnonzero(observation.owner == person.label)
    if len(cells) < options.body.seen_min_cells:
        return
    some = np.zeros(len(observation.owner), np.bool_)
    some[cells] = True
    part = parts(observation.cells.touching, some)[cells]
    count = np.bincount(part)
    if len(count) < 2:
        return
    rest = np.flatnonzero(count[part] < options.step.apart_share * count.max())
    if not len(rest):
        return
    there, middles = person.xyz + stride, observation.cells.middle[cells]
    gap = np.asarray(cKDTree(middles[part == count.argmax()]).query(middles[rest])[0])
    known = np.asarray(cKDTree(there).query(middles[rest])[0] < options.step.known_m)
    middle = np.median(there @ observation.flat, axis=0)
    known &= (
        np.linalg.norm(observation.ground[cells[rest]] - middle, axis=1)
        < options.step.known_beside_m
    )
    for number in np.unique(part[rest]).tolist():
        piece = part[rest] == number
        if (
            gap[piece].min() > options.step.apart_m
            and known[piece].mean() < options.body.majority_share
        ):
            observation.owner[cells[rest[piece]]] = 0
