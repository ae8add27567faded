"""Outcome of a track in a frame: seen or occluded, its confidence, and what it learns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.compute.grid import bounds, within
from pointbrush.tracking.compute.rigid import transform, transform_each
from pointbrush.tracking.interface import F64, I64, State, TrackOptions, TrackState
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.confidence import Evidence, likelihood
from pointbrush.tracking.model.registration import Place
from pointbrush.tracking.model.surface import remember
from pointbrush.tracking.model.track import InTheAir, LastSight, Thing
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Claim, together
from pointbrush.tracking.steps.context import unexplained
from pointbrush.tracking.steps.update import Sighting, learn, note_strain
from pointbrush.tracking.steps.verdict import Verdict, judge


def evidence(thing: Thing, sighting: Sighting, points: I64) -> Evidence:
    """What a fit says about itself, for the confidence of a thing; ``points`` (M,) are assigned."""
    view, place, found = sighting.view, sighting.place, sighting.found
    verdict = sighting.verdict
    m = max(len(found.indices), 1)
    count = max(len(points), 1)
    some = points[:: max(1, len(points) // thing.options.update.colour_points)]
    left, others = _beside(thing, view, place, points)
    return Evidence(
        inliers=verdict.inliers,
        sure=float((thing.model.hits[found.nearest] >= thing.options.surface.sure_hits).mean()),
        gap=float(found.gap.mean() / thing.reach),
        cost=float(found.cost.mean() / thing.reach),
        fit=place.cost,
        size=len(points) / max(thing.size, 1.0),
        change=len(points) / max(thing.last.points, 1),
        grown=1.0 - m / count,
        whole=place.whole,
        share=m / max(len(place.moving), 1),
        worn=thing.worn.likeness(view.colour(some)) - thing.worn.usual if thing.body else 0.0,
        usual=thing.in_the_air.cost,
        points=count,
        pixels=view.lens is not None,
        scans=thing.scanned,
        soft=thing.soft,
        left=(left + 1) / (len(points) + 1),
        others=(others + 1) / (len(points) + 1),
        tall=_height(thing, view, place, points),
        bend=thing.bending.share,
        coarse=thing.unit / max(thing.model.radius, thing.unit),
        border=place.border,
    )


def _beside(thing: Thing, view: View, place: Place, points: I64) -> tuple[int, int]:
    """How many moving points around a thing's ``points`` (M,) nobody has, and others have.

    Asked of lidars alone.
    """
    if not (thing.scanned and len(points)):
        return 0, 0
    lo, hi = bounds(view.xyz[points])
    margin = thing.options.update.left_over_units * thing.unit
    had = np.zeros(len(view.xyz), np.bool_)
    had[points] = True
    rest = place.moving[~had[place.moving]]
    rest = rest[within(view.xyz[rest], lo - margin, hi + margin)]
    had[place.had] = True
    others = int(had[rest].sum())
    return len(rest) - others, others


def _height(thing: Thing, view: View, place: Place, points: I64) -> float:
    """Height of a thing's ``points`` (M,) over its model's; asked of lidars alone."""
    if not (thing.scanned and len(points)):
        return 1.0
    whole = float(np.ptp(place.world[:, view.up]))
    return float(np.ptp(view.xyz[points, view.up])) / max(whole, thing.unit)


def settle(
    thing: Thing,
    view: View,
    place: Place | None,
    found: Claim | None,
    grown: I64,
    asked: TrackOptions,
) -> tuple[TrackState, I64]:
    """Judge what was found in a frame, and learn from it: the state, and the points (M,)."""
    options = thing.options.update
    pose, world = (None, None) if place is None else (place.pose, place.world)
    verdict = judge(thing, view, pose, world, found)
    seen = place is not None and _seen(thing, view, place, verdict)
    if place is None or found is None or not seen or hides(thing, view, place, found):
        return _unseen(thing, pose, verdict, asked), np.empty(0, np.int64)
    thing.missing = 0
    if thing.scanned and view.eye is not None:
        at = transform(place.pose, thing.motion.centre[None])[0]
        thing.come_to(float(np.linalg.norm(at - view.eye)))
    sighting = Sighting(view, place, found, grown, verdict)
    points = together(found.indices, grown)
    fit = evidence(thing, sighting, points)
    _trust(thing, place, fit)
    thing.last = LastSight(len(points), place.vain, place.cut_short, fit)
    _move(thing, place, verdict)
    if place.cost < options.motion_cost:
        note_strain(thing, sighting)
    # What bends fits badly as a whole, and well where it was bent.
    followed = (
        thing.soft and place.cost < options.motion_cost and verdict.inliers > options.reappear_share
    )
    if place.cost < options.teach_cost or thing.bends or thing.large or followed:
        learn(thing, replace(sighting, found=_lesson(thing, sighting)))
    if place.cost < options.teach_cost and not (thing.bends or thing.large):
        remember(thing.glimpses, view, place.pose, place.world)
    rmse = float(np.sqrt(np.mean(found.gap**2))) if len(found.gap) else 0.0
    track = TrackState(place.pose, rmse, verdict.inliers, thing.trust, len(points), "tracked")
    return track, together(points, place.rim)


def _unseen(thing: Thing, pose: F64 | None, verdict: Verdict, asked: TrackOptions) -> TrackState:
    """A thing was not seen in a frame, though it was looked for at a ``pose`` (4, 4)."""
    thing.missing += 1
    thing.motion.gap += 1
    lost = thing.missing > thing.options.update.lost_frames
    thing.stopped = lost and not asked.continue_lost
    thing.trust = max(0.0, thing.trust - thing.options.confidence.regain)
    state: State = "lost" if lost else "occluded"
    at = thing.motion.poses[-1] if pose is None else pose
    return TrackState(at, 0.0, verdict.inliers, 0.0, 0, state)


def _trust(thing: Thing, place: Place, fit: Evidence) -> None:
    """Trust a thing as far as this fit and the frames before allow."""
    options = thing.options
    here = likelihood(fit, thing.body, options=options.confidence)
    if place.whole and place.cost < options.update.teach_cost:
        cost = thing.in_the_air.cost
        cost += options.update.usual_cost_rate * (fit.cost - cost)
        thing.in_the_air = InTheAir(thing.in_the_air.frames + 1, cost)
    regain = options.confidence.regain_scanned if thing.scanned else options.confidence.regain
    thing.strayed = not place.whole and (thing.strayed or _strays(thing, place))
    most = min(place.most, options.update.astray_confidence) if thing.strayed else place.most
    thing.trust = min(here, thing.trust + regain, most)


def _strays(thing: Thing, place: Place) -> bool:
    """Whether what is in doubt, and has no colours to be known by, is found where no motion led.

    What bends has no shape that would tell it from an arm.
    """
    options = thing.options.update
    if thing.dyed or thing.large or thing.trust > options.astray_confidence:
        return False
    centre = thing.motion.centre[None]
    at = transform(place.pose, centre)[0]
    expected = transform_each(thing.motion.predictions(), centre)[:, 0]
    off = np.linalg.norm(expected - at, axis=1).min()
    return bool(off > options.astray_radii * thing.model.radius)


def _move(thing: Thing, place: Place, verdict: Verdict) -> None:
    """Let the motion of a thing take in where it was found."""
    # What was found so in the frame before too has moved from there to here.
    options = thing.options.update
    scrap = (
        thing.large and thing.last.points < options.scrap_share * thing.size and not thing.scanned
    )
    if scrap or (place.anew and not thing.motion.fresh):
        thing.motion.begin(place.pose)
    else:
        thing.motion.add(place.pose, sure=thing.large or place.cost < options.motion_cost)
    if thing.handy and well_seen(thing, verdict, thing.last.points):
        thing.motion.seen(thing.unit)


def well_seen(thing: Thing, verdict: Verdict, count: int) -> bool:
    """Whether a small thing with ``count`` points is seen well enough to tell whether it rests.

    What has turned or gone farther away shows fewer points, but in sight it tells that it moves.
    """
    options = thing.options
    if thing.motion.rests(thing.unit):
        return count > options.update.well_seen_share * thing.size
    in_sight = (
        verdict.visible > options.update.well_seen_share
        and verdict.inliers > options.update.reappear_share
    )
    return in_sight and count > options.track.hardly_share * thing.size


def _seen(thing: Thing, view: View, place: Place, verdict: Verdict) -> bool:
    """Whether the thing was found; one that was hidden must show itself clearly."""
    options = thing.options.update
    clear = place.cost < options.motion_cost and verdict.inliers > options.reappear_share
    if view.lens is None and np.array_equal(place.pose, thing.motion.poses[-1]):
        clear = verdict.inliers > options.stayed_share
    return verdict.found and (thing.missing == 0 or thing.large or clear)


def hides(thing: Thing, view: View, place: Place, found: Claim) -> bool:
    """Whether what was found hides a small thing, and is not the thing: it fits badly, and has
    hardly the colours that were painted, nor those of the known surface, another side's too.

    What is alone in the air hides nothing.
    """
    options = thing.options
    if not thing.dyed or place.cost < options.update.teach_cost or place.whole:
        return False
    colour = view.colour(found.indices)
    if not thing.worn.unlike(colour):
        return False
    known = ColourHistogram.of(
        thing.model.colour[thing.model.hits >= options.surface.sure_hits],
        options=thing.options,
    )
    return known.likeness(colour) < known.usual - options.update.hiding_log_colour


def _lesson(thing: Thing, sighting: Sighting) -> Claim:
    """What the model may learn of what was found: no new points that something unlabelled explains,
    or of colours that the thing has not shown: what holds it may be where it bends."""
    view, place, found = sighting.view, sighting.place, sighting.found
    if place.whole or thing.large:
        return found
    keep = found.gap < thing.options.surface.new_spacings * thing.model.spacing
    new = np.flatnonzero(~keep)
    keep[new] = ~thing.strange(view.colour(found.indices[new]))
    if not thing.bends:
        keep[new] &= unexplained(thing, view, place, found.indices[new])
    return found.pick(keep)
