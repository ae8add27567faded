"""How far each person has gone since the last frame, by the depth image; those in front first.

What a place on the ground would show is held against what is measured: surface that is seen
through is not there, hidden surface may be, and what is somebody's already is not another's.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import F32, F64, Mask
from pointbrush.tracking.people.observation import Observation
from pointbrush.tracking.people.person import Person
from pointbrush.tracking.sensor.lens import I32

GRID = (np.arange(13) - 6) / 2
"""Deviations that are tried each way."""


def strides(sight: Observation, people: Sequence[Person]) -> F64:
    """(K, 3) metres that each person has gone."""
    at = sight.view.cells.cell
    moving = sight.view.marked(sight.cells.indices)
    taken = np.zeros_like(moving)
    tints = np.zeros((len(sight.view.depth), 3), np.float32)
    if sight.tints is not None:
        tints[at[sight.cells.indices]] = sight.tints
    away = [float(np.median(sight.view.project(f.xyz).depth)) for f in people]
    found = np.zeros((len(people), 3))
    for k in sorted(range(len(people)), key=lambda k: (people[k].missing > 0, away[k])):
        found[k] = _stride(sight, people[k], moving & ~taken, tints)
        there = cKDTree(people[k].xyz + found[k])
        gap = there.query(
            sight.cells.middle, distance_upper_bound=sight.options.step.own_cells * sight.cells.size
        )[0]
        own = np.isfinite(gap)[sight.cells.cell]
        taken |= sight.view.marked(sight.cells.indices[own])
    return found


def _stride(sight: Observation, person: Person, loose: Mask, tints: F32) -> F64:
    options = sight.options.step
    varies = options.stride_m + options.stride_share * float(np.linalg.norm(person.step))
    varies += options.stride_m_per_frame * min(person.missing, options.max_unseen_frames)
    right, ahead = (axis.ravel() for axis in np.meshgrid(GRID, GRID))
    tried = person.step + varies * (
        right[:, None] * sight.flat[:, 0] + ahead[:, None] * sight.flat[:, 1]
    )
    some = slice(None, None, max(1, len(person.xyz) // options.sampled_cells))
    xyz, colour = person.xyz[some], person.colour[some]
    world = (xyz[None] + tried[:, None]).reshape(-1, 3)
    cell, depth = sight.view.project(world)
    cost = _costs(sight, cell, depth, loose)
    if sight.tints is not None:
        same = np.abs(sight.view.depth[cell] - depth) <= options.same_depth_m
        unlike = (
            np.linalg.norm(tints[cell] - np.tile(colour, (len(tried), 1)), axis=1)
            / options.other_colour
        )
        both = options.depth_weight * cost + options.colour_weight * np.minimum(1.0, unlike**2)
        cost = np.where(same & loose[cell], both, cost)
    total = (
        options.evidence_weight * cost.reshape(len(tried), -1).mean(axis=1)
        + (right**2 + ahead**2) / 2
    )
    return np.asarray(tried[total.argmin()])


def _costs(sight: Observation, cell: I32, depth: F32, loose: Mask) -> F64:
    """(M,) what surface costs at a ``depth`` (M,) of a ``cell`` (M,), by depth alone."""
    options = sight.options.step
    seen = sight.view.depth[cell]
    behind = seen - depth
    cost = np.where(behind > options.same_depth_m, 1.0, options.hidden_cost)
    same = np.abs(behind) <= options.same_depth_m
    cost[same] = np.where(loose[cell[same]], 0.5 * (behind[same] / options.same_depth_m) ** 2, 1.0)
    cost[np.isnan(seen)] = options.unknown_cost
    cost[cell < 0] = options.hidden_cost
    return cost
