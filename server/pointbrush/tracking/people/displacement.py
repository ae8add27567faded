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
STILL, FASTER, UNSEEN = 0.08, 0.45, 0.05
"""Metres by which a stride varies, the share of the last one, and metres a frame unseen."""
LONG = 6
"""Frames unseen after which nobody is searched for still farther away."""
SAMPLE = 120
"""Cells by which a place is judged."""
DEEP = 0.2
"""Metres within which surface is as deep as it should be."""
HIDDEN, UNKNOWN = 0.55, 0.5
"""What a cell costs that is hidden, and one where nothing is measured; seen through it costs 1."""
SHARE_DEPTH, SHARE_COLOUR, OTHER = 0.6, 0.7, 0.1
"""Weights of depth and of colour where there is any, and the difference of another colour."""
EVIDENCE = 14.0
"""Weight of the mean cost against half a squared deviation of the stride."""
OWN = 1.5
"""Cells from a person within which a cell is his."""


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
        gap = there.query(sight.cells.middle, distance_upper_bound=OWN * sight.cells.size)[0]
        own = np.isfinite(gap)[sight.cells.cell]
        taken |= sight.view.marked(sight.cells.indices[own])
    return found


def _stride(sight: Observation, person: Person, loose: Mask, tints: F32) -> F64:
    varies = STILL + FASTER * float(np.linalg.norm(person.step))
    varies += UNSEEN * min(person.missing, LONG)
    right, ahead = (axis.ravel() for axis in np.meshgrid(GRID, GRID))
    tried = person.step + varies * (
        right[:, None] * sight.flat[:, 0] + ahead[:, None] * sight.flat[:, 1]
    )
    some = slice(None, None, max(1, len(person.xyz) // SAMPLE))
    xyz, colour = person.xyz[some], person.colour[some]
    world = (xyz[None] + tried[:, None]).reshape(-1, 3)
    cell, depth = sight.view.project(world)
    cost = _costs(sight, cell, depth, loose)
    if sight.tints is not None:
        same = np.abs(sight.view.depth[cell] - depth) <= DEEP
        unlike = np.linalg.norm(tints[cell] - np.tile(colour, (len(tried), 1)), axis=1) / OTHER
        both = SHARE_DEPTH * cost + SHARE_COLOUR * np.minimum(1.0, unlike**2)
        cost = np.where(same & loose[cell], both, cost)
    total = EVIDENCE * cost.reshape(len(tried), -1).mean(axis=1) + (right**2 + ahead**2) / 2
    return np.asarray(tried[total.argmin()])


def _costs(sight: Observation, cell: I32, depth: F32, loose: Mask) -> F64:
    """(M,) what surface costs at a ``depth`` (M,) of a ``cell`` (M,), by depth alone."""
    seen = sight.view.depth[cell]
    behind = seen - depth
    cost = np.where(behind > DEEP, 1.0, HIDDEN)
    same = np.abs(behind) <= DEEP
    cost[same] = np.where(loose[cell[same]], 0.5 * (behind[same] / DEEP) ** 2, 1.0)
    cost[np.isnan(seen)] = UNKNOWN
    cost[cell < 0] = HIDDEN
    return cost
