"""Where a thing may be in the next frame: its predictions, and the points around them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pointbrush.tracking.background.depth_background import Background
from pointbrush.tracking.fitting.explain import Look, costs_of, look
from pointbrush.tracking.geometry.near import bounds
from pointbrush.tracking.geometry.registration import Target, transform_each
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensor.view import View


@dataclass(eq=False)
class Search:
    """A thing's part of the frame: points ``around`` its ``guesses`` (K, 4, 4), inside a ``box``.

    ``near`` are those that it may have, ``moving`` those before the background that were not
    there in the last frame either, ``faint`` those of ``near`` that are hardly before it.
    """

    thing: Thing
    view: View
    guesses: F64
    box: tuple[F64, F64]
    around: I64
    near: I64
    moving: I64
    faint: I64
    few: I64 = field(init=False)
    """Numbers of the model points that guesses are judged by."""
    many: I64 = field(init=False)
    """Numbers of those that the last iterations use."""
    target: Target = field(init=False)
    """What the model is fitted to: some of the moving points."""
    vain: bool = False
    """Other places were tried, and were no better."""

    @property
    def options(self) -> TrackerOptions:
        """The options of the run."""
        return self.view.options

    def __post_init__(self) -> None:
        """Choose what is compared."""
        options = self.options.search
        count = len(self.thing.model.xyz)
        self.few = np.arange(0, count, max(1, count // options.coarse_points))
        self.many = np.arange(0, count, max(1, count // options.fine_points))
        self.target = target_of(self.view, self.moving, self.thing.weight)

    @cached_property
    def costs(self) -> F64:
        """(K,) what each of the guesses costs, by the target as it is."""
        thing = self.thing
        return costs_of(
            thing,
            self.target,
            self.few,
            self.at,
            self.options.search.judged_units * thing.unit,
        )

    def aim(self, target: Target) -> None:
        """Look for it in another target."""
        self.target = target
        # What hides the thing depends on the target without a depth image only.
        known = ("costs",) if self.view.lens is not None else ("costs", "at", "own")
        for name in known:
            self.__dict__.pop(name, None)

    @cached_property
    def at(self) -> Look:
        """The few at each of the guesses."""
        return look(self.thing, self.view, self.few, self.guesses, self.own)

    @cached_property
    def own(self) -> I64 | None:
        """The directions in which what was measured may be the thing: it does not hide itself
        where it has come nearer than a prediction."""
        if self.view.lens is not None or self.view.shade is None:
            return None
        return self.view.shade.towards(self.target.xyz)

    @property
    def best(self) -> F64:
        """The likeliest prediction."""
        return np.asarray(self.guesses[np.argmin(self.costs)])


def crop(
    thing: Thing, view: View, background: Background, free: Mask, guesses: F64 | None = None
) -> Search | None:
    """Cut out what may be the thing, without what stood still; None where nothing is.

    ``guesses`` (K, 4, 4) where it may be, if not where it is predicted.
    """
    options = thing.options.search
    if guesses is None:
        guesses = _distinct(thing, thing.motion.predictions())
    at = transform_each(guesses, thing.motion.centre[None])[:, 0]
    radius, unit, gap = (
        thing.span,
        thing.unit,
        min(thing.motion.gap, options.max_growing_frames),
    )
    margin = (
        options.radii * radius
        + options.units * unit
        + (options.radii_unknown_motion * radius if thing.motion.fresh else 0.0)
    )
    margin += (options.speed_share * thing.motion.speed + options.units_per_frame * unit) * gap
    lo, hi = at.min(axis=0) - margin, at.max(axis=0) + margin
    around = view.box(lo, hi)
    around = around[free[around]]
    near = moving = around
    faint = around[:0]
    if len(around):
        far, still = background.static(view, around)
        if thing.large:
            speed = thing.motion.speed
            stay = (
                int(options.scenery_radii * radius / speed) + options.scenery_frames
                if speed > unit
                else options.never_frames
            )
            rest = np.flatnonzero(~far)
            far[rest] = background.scenery(view, around[rest], stay)
        # Only what is slow can be where something else was; what has just been revealed was not
        # seen there before, and may be the thing.
        slow = thing.motion.slow(unit)
        own = ~far if slow else ~(far | still)
        if slow and not thing.large:
            own = own | background.revealed(view, around)
        hardly = np.zeros(len(around), np.bool_)
        if slow and not thing.large:
            hardly = far & background.faint(view, around)
        near, faint, moving = around[own | hardly], around[hardly], around[~(far | still)]
        if view.roams and not thing.painted.flat:
            moving, around = moving[~view.low[moving]], around[~view.low[around]]
    if len(moving) < options.min_moving_points:
        return None
    search = Search(thing, view, guesses, (lo, hi), around, near, moving, faint)
    _ = search.costs  # which those who share the points out ask for
    return search


def _distinct(thing: Thing, guesses: F64) -> F64:
    """Those of the guesses (K, 4, 4) that are not as good as the same as one before them."""
    ends = transform_each(guesses, thing.ends)
    apart = np.abs(ends[:, None] - ends).max(axis=(2, 3))
    kept: list[int] = []
    for number in range(len(guesses)):
        if (
            not kept
            or apart[number, kept].min() > thing.options.search.same_pose_units * thing.unit
        ):
            kept.append(number)
    return guesses[kept]


def search_among(thing: Thing, view: View, points: I64) -> Search:
    """Look for a thing among ``points`` (M,) alone, that are known to be its own."""
    xyz = view.xyz[points].astype(np.float64)
    box = bounds(xyz)
    guesses = thing.motion.predictions()
    return Search(thing, view, guesses, box, points, points, points, points[:0])


def target_of(view: View, indices: I64, weight: float, most: int | None = None) -> Target:
    """An even part of the points, ``most`` of them, as a target of registration."""
    most = most or view.options.search.target_points
    some = indices[:: max(1, -(-len(indices) // most))]
    return Target(view.xyz[some].astype(np.float64), view.colour(some), weight)
