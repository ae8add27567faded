"""Predicted poses, the part of a frame around them, and its division among tracks that meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.columns import Columns, nearest_one, spans, toned
from pointbrush.tracking.compute.grid import bounds
from pointbrush.tracking.compute.rigid import Target, transform, transform_each
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.steps import SearchOptions
from pointbrush.tracking.scene.depth import NEVER, Background
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.verdict import Look, costs_of, look


@dataclass(frozen=True, eq=False)
class Search:
    """Part of the frame around an object's ``hypotheses`` (K, 4, 4), inside a ``box``.

    Indices of its points: ``around``, all; ``near``, available to the object; ``moving``, in front
    of the background and not there in the last frame; ``faint``, those of ``near`` barely in front
    of the background.  ``left``: target of the registration, all moving points if None.
    """

    track: Track
    view: View
    hypotheses: F64
    box: tuple[F64, F64]
    around: I64
    near: I64
    moving: I64
    faint: I64
    left: Target | None = None

    @property
    def options(self) -> TrackerOptions:
        """The options of the run."""
        return self.view.options

    @cached_property
    def few(self) -> I64:
        """Indices of the model points used to judge hypotheses."""
        return self._some(self.options.search.coarse_points)

    @cached_property
    def many(self) -> I64:
        """Indices of the model points used in the last iterations."""
        return self._some(self.options.search.fine_points)

    def _some(self, count: int) -> I64:
        total = len(self.track.model.xyz)
        return np.arange(0, total, max(1, total // count))

    @cached_property
    def target(self) -> Target:
        """Sample of the moving points, the target of the registration."""
        if self.left is not None:
            return self.left
        return target_of(self.view, self.moving, self.track.weight)

    @cached_property
    def costs(self) -> F64:
        """(K,) cost of each hypothesis without registration."""
        track = self.track
        return costs_of(
            track, self.target, self.few, self.at, self.options.search.judged_units * track.unit
        )

    @cached_property
    def at(self) -> Look:
        """Projection of the model points ``few`` at each hypothesis."""
        return look(self.track, self.view, self.few, self.hypotheses, self.own)

    @cached_property
    def own(self) -> list[I64] | None:
        """By sensor, directions in which measurements may be the object itself.

        It must not count as occluded by itself if it is nearer than predicted.
        """
        shades = [sight.shade for sight in self.view.sights if sight.shade is not None]
        return [shade.towards(self.target.xyz) for shade in shades] or None

    @property
    def best(self) -> F64:
        """The most likely prediction."""
        return np.asarray(self.hypotheses[np.argmin(self.costs)])


def crop(
    track: Track, view: View, background: Background, free: Mask, hypotheses: F64 | None = None
) -> Search | None:
    """Return the part of the frame that may be the object, without static points; None: empty.

    ``hypotheses`` (K, 4, 4): possible poses, by default the predictions.
    """
    options = track.options.search
    if hypotheses is None:
        hypotheses = _distinct(track, track.motion.predictions)
    at = transform_each(hypotheses, track.motion.centre[None])[:, 0]
    margin = _search_margin(track)
    lo, hi = at.min(axis=0) - margin, at.max(axis=0) + margin
    around = view.box(lo, hi)
    around = around[free[around]]
    near = moving = around
    faint = around[:0]
    if len(around):
        near, moving, faint = _before_background(track, view, background, around)
        if view.roams and not track.painted.flat:
            moving, around = moving[~view.low[moving]], around[~view.low[around]]
    if track.carrier is not None:
        near, moving, faint = (
            _without_clothes(track, view, points) for points in (near, moving, faint)
        )
    if len(moving) < options.min_moving_points:
        return None
    search = Search(track, view, hypotheses, (lo, hi), around, near, moving, faint)
    _ = search.costs  # cached for ``share_out``
    return search


def _without_clothes(track: Track, view: View, points: I64) -> I64:
    """Return the points (M,) that do not clearly have the colours of a person's clothes."""
    over = track.over_clothes(view.colour(points))
    return points[over > -track.options.body.distinct_log]


def _search_margin(track: Track) -> float:
    """Return the margin (m) around predicted centres in which a track's points may lie."""
    options = track.options.search
    radius, unit = track.span, track.unit
    gap = min(track.motion.gap, options.max_growing_frames)
    margin = (
        options.radii * radius
        + options.units * unit
        + (options.radii_unknown_motion * radius if track.motion.is_unknown else 0.0)
    )
    return (
        margin + (options.speed_share * track.motion.speed + options.units_per_frame * unit) * gap
    )


def _before_background(
    track: Track, view: View, background: Background, around: I64
) -> tuple[I64, I64, I64]:
    """Return the ``near``, ``moving`` and ``faint`` points of ``around`` (P,); see ``Search``."""
    options = track.options.search
    far, still = background.static(view, around)
    if track.stands:  # Its missed points are static as well.
        far &= ~background.faint(view, around)
    if track.large:
        speed = track.motion.speed
        stay = (
            int(options.scenery_radii * track.span / speed) + options.scenery_frames
            if speed > track.unit
            else NEVER
        )
        rest = np.flatnonzero(~far)
        far[rest] = background.scenery(view, around[rest], stay)
    # Only a slow object can be at another object's former place.
    slow = track.motion.slow(track.unit)
    own = ~far if slow else ~(far | still)
    barely_in_front = np.zeros(len(around), np.bool_)
    if slow and not track.large:
        barely_in_front = far & background.faint(view, around)
    return around[own | barely_in_front], around[~(far | still)], around[barely_in_front]


def _distinct(track: Track, hypotheses: F64) -> F64:
    """Return the hypotheses (K, 4, 4) without near duplicates of earlier ones."""
    ends = transform_each(hypotheses, track.ends)
    apart = np.abs(ends[:, None] - ends).max(axis=(2, 3))
    kept: list[int] = []
    for number in range(len(hypotheses)):
        if (
            not kept
            or apart[number, kept].min() > track.options.search.same_pose_units * track.unit
        ):
            kept.append(number)
    return hypotheses[kept]


def search_among(track: Track, view: View, points: I64) -> Search:
    """Return a search for an object in ``points`` (M,) known to be its own."""
    xyz = view.xyz[points].astype(np.float64)
    box = bounds(xyz)
    hypotheses = track.motion.predictions
    return Search(track, view, hypotheses, box, points, points, points, points[:0])


def target_of(view: View, indices: I64, weight: float, most: int | None = None) -> Target:
    """Return a uniform sample of at most ``most`` points a sensor as a target of registration."""
    most = view.per_sensor(most or view.options.search.target_points)
    some = indices[:: max(1, -(-len(indices) // most))]
    return Target(view.xyz[some].astype(np.float64), view.colour(some), weight)


def share_out(searches: Mapping[int, Search], options: SearchOptions) -> dict[int, Search]:
    """Remove points from each target that another object's prediction explains clearly better."""
    ghosts = {label: _ghost(search) for label, search in searches.items()}
    sure = [n for n, search in searches.items() if min(search.costs) < _limit(search.track)]
    shared = dict(searches)
    for label, search in searches.items():
        left, ghost = search.target, ghosts[label]
        drop = np.zeros(len(left.xyz), np.bool_)
        for other in sure:
            if other != label and ghosts[other].meets(ghost, options=options):
                _drop_theirs(
                    drop,
                    left.xyz,
                    left.colour,
                    ghost.surface,
                    ghosts[other].surface,
                    options.explained_units * searches[other].track.unit,
                    options.clearly_nearer_share,
                )
        if drop.any() and (~drop).sum() >= options.min_moving_points:
            target = Target(left.xyz[~drop], left.colour[~drop], left.weight)
            shared[label] = replace(search, left=target)
    return shared


def _limit(track: Track) -> float:
    """Return the cost up to which a prediction is certain; it depends on the known motion."""
    options = track.options.register
    if track.motion.is_unknown:
        return options.clear_cost if track.hand_sized else 0.0
    return options.doubt_body if track.large else options.doubt


class _Surface(NamedTuple):
    """Sorted points, and the corners (3,) of their bounding box."""

    columns: Columns
    lo: F64
    hi: F64


@dataclass(frozen=True, slots=True, eq=False)
class _Ghost:
    """An object at its prediction, by position and colour."""

    surface: _Surface
    centre: F64
    radius: float

    def meets(self, other: _Ghost, options: SearchOptions) -> bool:
        """Return whether the two are near each other."""
        offset = self.centre - other.centre
        return float(offset @ offset) < (options.meeting_radii * (self.radius + other.radius)) ** 2


def _ghost(search: Search) -> _Ghost:
    model, many, weight = search.track.model, search.many, search.target.weight
    world = transform(search.best, model.xyz[many])
    columns = Target(world, model.colour[many], weight).columns
    centre = transform(search.best, search.track.motion.centre[None])[0]
    return _Ghost(_Surface(columns, *bounds(world)), centre, model.radius)


@compiled
def _drop_theirs(
    drop: Mask,
    xyz: F64,
    colour: F32,
    own: _Surface,
    theirs: _Surface,
    reach: float,
    clearly_nearer_share: float,
) -> None:
    """Mark points (N, 3) clearly nearer to another object's surface than to their own one."""
    mine, others = own.columns, theirs.columns
    room, other_room = spans(mine), spans(others)
    for i in range(len(xyz)):
        x, y, z = xyz[i, 0], xyz[i, 1], xyz[i, 2]
        gap = max(theirs.lo[0] - x, x - theirs.hi[0], theirs.lo[1] - y, y - theirs.hi[1])
        if drop[i] or max(gap, theirs.lo[2] - z, z - theirs.hi[2]) > reach:
            continue
        tint = toned(others, colour, i)
        square, at = nearest_one(others, (x, y, z), tint, reach, other_room)
        if at >= 0:
            tint = toned(mine, colour, i)
            drop[i] = (
                square
                < clearly_nearer_share**2 * nearest_one(mine, (x, y, z), tint, 2 * reach, room)[0]
            )
