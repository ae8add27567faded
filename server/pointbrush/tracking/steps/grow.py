"""New surface beside claimed points, by connectivity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.columns import NONE, any_near, columns
from pointbrush.tracking.compute.grid import bounds, close_to, within
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Place
from pointbrush.tracking.model.surface import carved
from pointbrush.tracking.model.track import Thing
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.alone import whole
from pointbrush.tracking.steps.claim import Claim, Findings, claim, flying, outline, together
from pointbrush.tracking.steps.context import contested, unexplained
from pointbrush.tracking.steps.pieces import lost_pieces


class Limits(NamedTuple):
    """Where what hangs together with a thing has to end, to be all of it.

    After ``steps`` of ``reach`` metres and with ``most`` points at most, all of them from ``low``
    (3,) to ``high`` (3,).
    """

    reach: float
    steps: int
    most: int
    low: F64
    high: F64


def connected(core: F64, rest: F64, reach: float, rounds: int) -> Mask:
    """Which of ``rest`` (N, 3) hang together with ``core`` over steps of ``reach`` metres."""
    joined = np.zeros(len(rest), np.bool_)
    front = core
    for _ in range(rounds):
        open_ = np.flatnonzero(~joined)
        if not len(open_) or not len(front):
            break
        new = open_[close_to(rest[open_], front, reach)]
        joined[new] = True
        front = rest[new]
    return joined


def blob(view: View, core: I64, rest: I64, limits: Limits) -> I64 | None:
    """All of ``rest`` that hangs together with ``core``; None where that does not end within the
    ``limits``.

    What moves alone in the air is the object, new surface and all; what does not end within a
    few steps hangs together with something larger (a hand, a body).
    """
    front = view.xyz[core].astype(np.float64)
    lo, hi = bounds(front)
    far = limits.steps * limits.reach
    rest = rest[within(view.xyz.take(rest, axis=0), lo - far, hi + far)]
    joined, ends = flood(front, view.xyz[rest].astype(np.float64), limits)
    return rest[joined] if ends else None


@compiled
def flood(core: F64, rest: F64, limits: Limits) -> tuple[Mask, bool]:
    """Which of ``rest`` (N, 3) hang together with ``core`` (M, 3).

    And whether they end within the ``limits``; else they are not all.
    """
    reach, low, high = limits.reach, limits.low, limits.high
    joined, order = np.zeros(len(rest), np.bool_), np.empty(len(rest), np.int64)
    count = _beside(core, rest, reach, joined, order)
    if count == 0:
        return joined, True
    first, grid = 0, columns(rest, NONE, 0.0)
    steps = int(reach / grid.size) + 1
    # Of each column those that have not joined, so that none is asked again.
    left, ends = np.arange(len(rest)), grid.start[1:].copy()
    for _ in range(limits.steps):
        last = count
        if first == last:
            return joined, True
        for k in range(first, last):
            for a in range(3):
                if not low[a] <= rest[order[k], a] <= high[a]:
                    return joined, False
        if count > limits.most:
            return joined, False
        for k in range(first, last):
            at = rest[order[k]]
            row = int((at[grid.axes[0]] - grid.low[0]) / grid.size)
            column = int((at[grid.axes[1]] - grid.low[1]) / grid.size)
            low_, high_ = max(column - steps, 0), min(column + steps, grid.across - 1)
            for other in range(max(row - steps, 0), min(row + steps, grid.along - 1) + 1):
                for here in range(other * grid.across + low_, other * grid.across + high_ + 1):
                    i = grid.start[here]
                    while i < ends[here]:
                        point, square = grid.order[left[i]], 0.0
                        for a in range(3):
                            square += (rest[point, a] - at[a]) ** 2
                        if not joined[point] and square >= reach * reach:
                            i += 1
                            continue
                        if not joined[point]:
                            joined[point] = True
                            order[count] = point
                            count += 1
                        ends[here] -= 1
                        left[i] = left[ends[here]]
        first = last
    return joined, first == count


@compiled
def _beside(core: F64, rest: F64, reach: float, joined: Mask, order: I64) -> int:
    """Mark which of ``rest`` are near the core; how many, whose numbers now begin ``order``."""
    lo, hi = bounds(core)
    grid, count = columns(core, NONE, 0.0), 0
    for i in range(len(rest)):
        x, y, z = rest[i, 0], rest[i, 1], rest[i, 2]
        away = max(lo[0] - x, x - hi[0], lo[1] - y, y - hi[1], lo[2] - z, z - hi[2])
        if away < reach and any_near(grid, (x, y, z), (0.0, 0.0, 0.0), reach):
            joined[i] = True
            order[count] = i
            count += 1
    return count


LABELS = 2**16
"""Labels that there can be."""


def own_points(thing: Thing, view: View, place: Place) -> Claim:
    """Points like the model at its place, and not more like something unlabelled."""
    # What is beside a large thing is told by what hangs together.
    options = thing.options
    wide = (options.claim.reaches if thing.large else options.claim.new_reaches) * thing.reach
    near = claim(view, place.near, place.world, thing.model.colour, thing.weight, wide)
    not_its = contested(view, near, thing, place)
    place.neutral = near.indices[~not_its]
    not_its &= near.cost > thing.reach
    moving = np.zeros(len(view.xyz), np.bool_)
    moving[place.moving] = True
    if view.roams:
        moving |= view.low
    not_its |= ~moving[near.indices] & (near.cost > options.claim.still_reaches * thing.reach)
    not_its |= _hardly(view, place)[near.indices] & (
        (near.cost > thing.reach) | (thing.model.hits[near.nearest] < options.surface.sure_hits)
    )
    beyond = thing.reach if thing.large else thing.unit
    unlike = near.cost > thing.reach + (options.claim.reaches_coloured - 1) * beyond
    unlike &= near.gap > options.claim.shaded_reaches * thing.reach
    if not thing.painted.flat:  # The ground touches what stands on it, and goes on.
        not_its |= view.low[near.indices] & (near.gap > options.claim.foot_reaches * thing.reach)
    found = near.pick(
        ~not_its & ~unlike & (near.gap < thing.reach + (options.claim.reaches - 1) * beyond)
    )
    # A pose is never exact: what lies on well confirmed surface is not asked.
    firm = (thing.model.hits[found.nearest] >= options.surface.sure_hits) & (
        found.gap < options.claim.firm_reaches * thing.reach
    )
    return found.pick(firm | ~_carved(thing, view, place, found.indices))


def _hardly(view: View, place: Place) -> Mask:
    """(N,) points that hardly stand out against the background."""
    hardly = np.zeros(len(view.xyz), np.bool_)
    hardly[place.faint] = True
    return hardly


def grow(things: Mapping[int, Thing], findings: Findings) -> tuple[dict[int, I64], Mask]:
    """New surface: moving points that hang together with a thing, free and nobody's.

    Of all but large things; and which points (N,) somebody has then.  Claims lose their flying
    pixels, which are rivals of nothing.
    """
    view, background, free = findings.view, findings.background, findings.free
    places, claims = findings.places, findings.claims
    taken = ~findings.unclaimed()
    shown, hider = background.uncovered(view)
    grown: dict[int, I64] = {}
    for label, place in places.items():
        thing, core = things[label], claims[label].indices
        rest = place.moving[~taken[place.moving]]
        if len(core) < findings.view.options.claim.min_claim_points or thing.large:
            continue
        new = whole(thing, view, place, core, taken, free) if len(rest) else None
        place.whole = new is not None
        if new is None:
            new = _adjoin(thing, view, place, core, rest)
            mine = (hider != label) & ~taken[shown]
            place.uncovered = together(
                _shown(thing, view, core, shown[mine], hider[mine]),
                lost_pieces(thing, view, place, core, taken, background),
            )
            new = together(new, place.uncovered)
        taken[new] = True
        claims[label], grown[label] = _solid(thing, view, place, claims[label], new)
    for label in grown:
        claims[label], grown[label] = _outlined(things[label], findings, grown[label], taken)
    for label, new in grown.items():
        if not things[label].dyed:
            own, rest = np.concatenate([claims[label].indices, new]), places[label].moving
            places[label].border = _border(view, own, rest[~taken[rest]], things[label].unit)
    return grown, taken


def _border(view: View, own: I64, rest: I64, unit: float) -> float:
    """Share of a thing's points ``own`` (M,) that touch some of the ``rest`` (N,)."""
    options = view.options.claim
    some = view.xyz[own[:: max(1, len(own) // options.border_points)]]
    return (
        float(close_to(some, view.xyz[rest], options.touching_units * unit).mean())
        if len(some)
        else 0.0
    )


def _solid(thing: Thing, view: View, place: Place, found: Claim, new: I64) -> tuple[Claim, I64]:
    """A claim and new surface of what is on the move without flying pixels.

    Thin parts and rims of what stays in its place are known; of what has just been painted little
    is known but that it is there.
    """
    if thing.motion.fresh or thing.motion.rests(thing.unit):
        return found, new
    count = len(found.indices)
    points = np.concatenate([found.indices, new])
    kept = ~flying(view, points, thing.unit)
    if kept.all():
        return found, new
    place.neutral = np.concatenate([place.neutral, points[~kept]])
    return found.pick(kept[:count]), new[kept[count:]]


def _outlined(thing: Thing, findings: Findings, new: I64, taken: Mask) -> tuple[Claim, I64]:
    """The claim and new surface of what is slow without flying pixels.

    ``Place.rim`` takes in what was missed at its outline, and those if it was painted with them.
    """
    view, background = findings.view, findings.background
    place, found = findings.places[thing.label], findings.claims[thing.label]
    if view.lens is None or not thing.motion.slow(thing.unit):
        return found, new
    own = np.concatenate([found.indices, new])
    rest = place.around[~taken[place.around]]
    rest = rest[~background.static(view, rest)[0] | background.faint(view, rest)]
    flies, rim = outline(view, own, rest, thing.unit)
    count = len(found.indices)
    place.rim = rest[rim]
    if thing.painted.with_flying:
        place.rim = together(place.rim, own[flies])
    else:
        place.neutral = np.concatenate([place.neutral, own[flies]])
        taken[own[flies]] = False
    taken[rest[rim]] = True
    return found.pick(~flies[:count]), new[~flies[count:]]


def _carved(thing: Thing, view: View, place: Place, points: I64) -> Mask:
    if thing.bends or thing.soft or thing.large or place.cost > thing.options.claim.sharp_cost:
        return np.zeros(len(points), np.bool_)
    return carved(thing.glimpses, view, place.pose, points, thing.unit)


def _adjoin(thing: Thing, view: View, place: Place, core: I64, rest: I64) -> I64:
    """Points beside the core, of its colour, that nothing unlabelled explains."""
    options = thing.options.claim
    colour = view.colour(rest)
    own = thing.distinct(colour)
    may = own | (unexplained(thing, view, place, rest) & ~thing.strange(colour))
    rest, own = rest[may], own[may]
    weight = thing.weight * (options.bent_colour_weight if thing.bends else 1.0)
    joined = connected(
        _placed(view, core, weight),
        _placed(view, rest, weight),
        (options.coloured_units_bent if thing.bends else options.coloured_units) * thing.unit,
        options.bent_steps if thing.bends else 1,
    )
    if own.any():  # Nothing else has its colours: it goes on as far as they do.
        front = np.concatenate([core, rest[joined]])
        more = np.flatnonzero(own & ~joined)
        at, beside = (view.xyz[points].astype(np.float64) for points in (front, rest[more]))
        on = connected(
            at,
            beside,
            options.coloured_units * thing.unit,
            options.uncovered_steps,
        )
        joined[more[on]] = True
    return rest[joined]


def _shown(thing: Thing, view: View, core: I64, shown: I64, hider: I64) -> I64:
    """What others uncovered of a thing at rest: it hangs together with it, alike in colour.

    It has to be a good part of all that the other, its ``hider``, uncovered: beside a thing in
    a hand that is mostly what holds it, and whom.
    """
    options = thing.options
    if thing.bends or not thing.motion.rests(thing.unit):
        return shown[:0]
    front, rest = (_placed(view, points, thing.weight) for points in (core, shown))
    joined = connected(
        front,
        rest,
        options.growth.step_units * thing.unit,
        options.claim.uncovered_steps,
    )
    own, every = (np.bincount(h, minlength=LABELS) for h in (hider[joined], hider))
    return np.asarray(shown[joined & (own > options.claim.uncovered_share * every)[hider]])


def _placed(view: View, indices: I64, weight: float) -> F64:
    """(M, 6) place and weighted colour."""
    return np.hstack([view.xyz[indices], view.colour(indices) * weight]).astype(np.float64)
