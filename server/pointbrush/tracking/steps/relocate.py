"""Search in the whole frame for tracks that went astray."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pointbrush.tracking.compute.graph import pieces
from pointbrush.tracking.compute.grid import within
from pointbrush.tracking.compute.rigid import excess, transform, transform_each
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Place
from pointbrush.tracking.model.track import Thing
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Claim, Findings
from pointbrush.tracking.steps.grow import own_points
from pointbrush.tracking.steps.predict import Search, crop
from pointbrush.tracking.steps.propose import alike, turned_at
from pointbrush.tracking.steps.register import find
from pointbrush.tracking.steps.verdict import judge


def find_astray(things: Iterable[Thing], astray: dict[int, int], findings: Findings) -> None:
    """Look for ``things`` that fit badly or not at all; ``findings`` take them in.

    ``astray`` label → frames for which a thing was nowhere near where it should be; kept up.
    """
    view, background = findings.view, findings.background
    some = [thing for thing in things if _is_astray(thing, astray, findings)]
    if not some:
        return
    left = findings.unclaimed(but={thing.label for thing in some})
    points = np.flatnonzero(left)
    far, still = background.static(view, points)
    points = points[~(far | still)]
    for thing in some:
        before = _own(thing, findings)
        found = _alone(thing, background, view, findings.unclaimed(), before)
        if found is None:
            found = _best(thing, background, view, left, points[left[points]], before)
        if found is not None:
            findings.put(thing.label, *found)
            left[found[1].indices] = False
            astray.pop(thing.label, None)


def _is_astray(thing: Thing, astray: dict[int, int], findings: Findings) -> bool:
    """Whether a thing is to be looked for in this frame; the frames in doubt are counted."""
    options = thing.options.relocate
    view, place = findings.view, _own(thing, findings)
    if view.lens is None or thing.large or thing.bends or thing.stopped:
        return False
    if place is not None and place.cost < options.doubt:
        astray.pop(thing.label, None)
        return False
    count = astray[thing.label] = astray.get(thing.label, 0) + 1
    return (
        count <= options.patient_frames or (view.number + thing.label) % options.retry_frames == 0
    )


def _own(thing: Thing, findings: Findings) -> Place | None:
    """The place of a thing, None where it is another's, or hardly anything of it elsewhere."""
    place, claim = findings.places.get(thing.label), findings.claims.get(thing.label)
    if place is None or claim is None or place.undisputed < thing.options.relocate.others_share:
        return None
    return None if _scrap(thing, place, claim) else place


def _scrap(thing: Thing, place: Place, claim: Claim) -> bool:
    """Whether hardly anything of a thing shows at a place where no motion led."""
    at = transform(place.pose, thing.motion.centre[None])
    away = np.linalg.norm(_expected(thing) - at, axis=1).min()
    return bool(
        away > thing.model.radius
        and len(claim.indices) < thing.options.relocate.shown_far_share * thing.size
    )


def _alone(
    thing: Thing, background: Background, view: View, nobodys: Mask, before: Place | None
) -> tuple[Place, Claim] | None:
    """The thing where it should be, if something like it is alone there that nobody has.

    It has to fit better than ``before``.
    """
    options = thing.options.relocate
    most = options.alone_cost if before is None else min(options.alone_cost, before.cost)
    middle = _lone_piece(thing, background, view, nobodys)
    if middle is None:
        return None
    guesses = turned_at(thing.model, thing.motion.poses[-1], middle)
    search = crop(thing, view, background, nobodys, guesses)
    if search is None:
        return None
    place = find(search)
    claim = own_points(thing, view, place)
    seen = judge(thing, view, place.pose, place.world, claim).found
    seen = seen and not _scrap(thing, place, claim)
    return (place, claim) if seen and place.cost < most else None


def _expected(thing: Thing) -> F64:
    """(K, 3) where the middle of a thing is predicted."""
    return transform_each(thing.motion.predictions(), thing.motion.centre[None])[:, 0]


def _lone_piece(thing: Thing, background: Background, view: View, nobodys: Mask) -> F64 | None:
    """Middle (3,) of what is alone, of the thing's size and colours, nearest to a prediction."""
    options = thing.options
    at = _expected(thing)
    margin = options.relocate.alone_radii * thing.model.radius
    lo, hi = at.min(axis=0) - margin, at.max(axis=0) + margin
    around = view.box(lo, hi)
    around = around[~background.static(view, around)[0]]
    if not len(around):
        return None
    xyz = view.xyz[around].astype(np.float64)
    piece = pieces(xyz, thing.unit, options=options.link)
    size = np.bincount(piece)
    ends = within(xyz, lo + thing.unit, hi - thing.unit)
    fits = (size >= options.relocate.size_share_min * thing.size) & (
        size <= options.relocate.alone_size_share * thing.size
    )
    fits &= np.bincount(piece[~ends], minlength=len(size)) == 0
    fits &= (
        np.bincount(piece[~nobodys[around]], minlength=len(size))
        <= options.relocate.claimed_share * size
    )
    best, nearest = None, thing.model.radius
    for one in np.flatnonzero(fits).tolist():
        middle = xyz[piece == one].mean(axis=0)
        away = float(np.linalg.norm(at - middle, axis=1).min())
        like = thing.worn.share(view.colour(around[piece == one]))
        if away < nearest and like > options.relocate.alone_colours_share:
            best, nearest = middle, away
    return best


def _best(
    thing: Thing, background: Background, view: View, left: Mask, points: I64, before: Place | None
) -> tuple[Place, Claim] | None:
    """Where a thing fits best among the ``points`` (M,): well, and far better than ``before``."""
    options = thing.options
    best, most = (
        None,
        options.relocate.clear_cost
        if before is None
        else min(options.relocate.clear_cost, options.relocate.better_ratio * before.cost),
    )
    last = thing.motion.poses[-1]
    guesses = [turned_at(thing.model, last, at) for at in _clusters(thing, view, points)]
    searches = [crop(thing, view, background, left, some) for some in guesses]
    likely = [search for search in searches if search is not None]
    for search in sorted(likely, key=lambda search: float(search.costs.min()))[
        : options.relocate.tries
    ]:
        place = find(search)
        cost = place.cost + excess(place.world, search.target, thing.unit, options=options.register)
        if cost >= most:
            continue
        claim = own_points(thing, view, place)
        if _scrap(thing, place, claim):
            continue
        verdict = judge(thing, view, place.pose, place.world, claim)
        if (
            verdict.found
            and verdict.inliers > options.relocate.matched_share
            and _looks_like(thing, view, claim)
        ):
            place.anew = _is_elsewhere(thing, place, before)
            best, most = (place, claim), cost
    return best


def _looks_like(thing: Thing, view: View, claim: Claim) -> bool:
    """Whether what is claimed has the colours that a thing was painted with, as no arm has."""
    return (
        thing.worn.share(view.colour(claim.indices)) > thing.options.relocate.painted_colours_share
    )


def _is_elsewhere(thing: Thing, place: Place, before: Place | None) -> bool:
    """Whether a thing is not where it was found ``before``, and only turned another way."""
    if before is None:
        return True
    here, there = (transform(at.pose, thing.model.centre[None]) for at in (place, before))
    return float(np.linalg.norm(here - there)) > thing.model.radius


def _clusters(thing: Thing, view: View, points: I64) -> list[F64]:
    """Middles (3,) of what hangs together in the thing's colours, the likeliest sizes first."""
    options = thing.options
    if thing.weight > 0.0:
        points = points[alike(thing.model, view.colour(points))]
    if not len(points):
        return []
    xyz = view.xyz[points].astype(np.float64)
    piece = pieces(xyz, thing.unit, options=options.link)
    size = np.bincount(piece)
    fitting = np.flatnonzero(
        (size >= options.relocate.size_share_min * thing.size)
        & (size <= options.relocate.size_share_max * thing.size)
    )
    order = np.argsort(np.abs(np.log(size[fitting] / thing.size)), kind="stable")
    return [
        xyz[piece == one].mean(axis=0)
        for one in fitting[order][: options.relocate.clusters].tolist()
    ]


def placed(thing: Thing, view: View, search: Search) -> tuple[Place, Claim]:
    """Where a thing is, and what it would have there: nothing where it should be hidden, and
    nobody comes so fast."""
    place = find(search)
    if thing.body and _far_off(thing, search, place):
        return place, Claim.nothing()
    return place, own_points(thing, view, place)


def _far_off(thing: Thing, search: Search, place: Place) -> bool:
    """Whether a large thing would be far from where it is hidden now: that is somebody else."""
    options = thing.options
    motion = thing.motion
    if motion.fresh or thing.painted.cut:  # what was painted in part grows by what comes out
        return False
    centre = motion.centre[None]
    at = transform(place.pose, centre)[0]
    off = np.linalg.norm(transform_each(search.guesses, centre)[:, 0] - at, axis=1).min()
    if off < (options.relocate.hidden_radii * thing.span + motion.speed) * motion.gap:
        return False
    guesses = transform_each(search.guesses, thing.model.xyz[search.few])
    hidden = search.view.hides(guesses.reshape(-1, 3), options.verdict.hidden_units * thing.unit)
    return bool(hidden.reshape(len(guesses), -1).mean(axis=1).max() > options.relocate.shown_share)
