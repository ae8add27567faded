"""What a run makes of a thing in a frame: found, hidden or lost; what it learns of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.fitting.judge import Verdict, judge
from pointbrush.tracking.geometry.registration import transform, transform_each
from pointbrush.tracking.interface import F64, I64, State, TrackOptions, TrackState
from pointbrush.tracking.objects.colours import ColourHistogram
from pointbrush.tracking.objects.confidence import REGAIN, REGAIN_SCANNED, Evidence, likelihood
from pointbrush.tracking.objects.free_space import remember
from pointbrush.tracking.objects.model import NEW_SURFACE, SURE
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.objects.thing import HARDLY, InTheAir, LastSight, Thing
from pointbrush.tracking.segmentation.assign import Claim, together
from pointbrush.tracking.segmentation.explained import unexplained
from pointbrush.tracking.sensor.view import View
from pointbrush.tracking.update.bending import note_strain
from pointbrush.tracking.update.evidence import evidence
from pointbrush.tracking.update.learn import learn
from pointbrush.tracking.update.sighting import Sighting

PATIENCE = 45
"""Frames that a thing is looked for before it is lost."""
SOUND = 0.25
"""Cost under which a fit teaches the model."""
DOUBTFUL, REGAINED = 0.4, 0.6
"""Cost over which a fit says nothing about the motion; under it, and with this share of inliers,
it ends an occlusion."""
GRADUAL = 0.1
"""Share of a frame in what a thing's points usually cost."""
SCRAP = 0.05
"""Share of the size of a large thing under which what is seen of it tells no motion."""
LESS = 0.6
"""How much rarer, in the mean logarithm, colours may be on the known surface than its own usually
are: half as common. It is known better than what was painted, and of all sides."""
WELL = 0.5
"""Share of its size, and of what faces the sensor, from which a small thing is well seen."""
DOUBTED, ELSEWHERE = 0.45, 0.5
"""Confidence up to which a thing may be another where it is found elsewhere, and that it has there
at most; and radii from all predictions from which that is so."""
STAYED = 0.35
"""Share of inliers that is enough for what is found where it was, if what hides it is not known."""


def settle(
    thing: Thing,
    view: View,
    place: Place | None,
    found: Claim | None,
    grown: I64,
    options: TrackOptions,
) -> tuple[TrackState, I64]:
    """Judge what was found in a frame, and learn from it: the state, and the points (M,)."""
    pose, world = (None, None) if place is None else (place.pose, place.world)
    verdict = judge(thing, view, pose, world, found)
    seen = place is not None and _seen(thing, view, place, verdict)
    if place is None or found is None or not seen or hides(thing, view, place, found):
        return _unseen(thing, pose, verdict, options), np.empty(0, np.int64)
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
    if place.cost < DOUBTFUL:
        note_strain(thing, sighting)
    # What bends fits badly as a whole, and well where it was bent.
    followed = thing.soft and place.cost < DOUBTFUL and verdict.inliers > REGAINED
    if place.cost < SOUND or thing.bends or thing.large or followed:
        learn(thing, replace(sighting, found=_lesson(thing, sighting)))
    if place.cost < SOUND and not (thing.bends or thing.large):
        remember(thing.glimpses, view, place.pose, place.world)
    rmse = float(np.sqrt(np.mean(found.gap**2))) if len(found.gap) else 0.0
    track = TrackState(place.pose, rmse, verdict.inliers, thing.trust, len(points), "tracked")
    return track, together(points, place.rim)


def _unseen(thing: Thing, pose: F64 | None, verdict: Verdict, options: TrackOptions) -> TrackState:
    """A thing was not seen in a frame, though it was looked for at a ``pose`` (4, 4)."""
    thing.missing += 1
    thing.motion.gap += 1
    lost = thing.missing > PATIENCE
    thing.stopped = lost and not options.continue_lost
    thing.trust = max(0.0, thing.trust - REGAIN)
    state: State = "lost" if lost else "occluded"
    at = thing.motion.poses[-1] if pose is None else pose
    return TrackState(at, 0.0, verdict.inliers, 0.0, 0, state)


def _trust(thing: Thing, place: Place, fit: Evidence) -> None:
    """Trust a thing as far as this fit and the frames before allow."""
    here = likelihood(fit, thing.body)
    if place.whole and place.cost < SOUND:
        cost = thing.in_the_air.cost
        cost += GRADUAL * (fit.cost - cost)
        thing.in_the_air = InTheAir(thing.in_the_air.frames + 1, cost)
    regain = REGAIN_SCANNED if thing.scanned else REGAIN
    thing.strayed = not place.whole and (thing.strayed or _strays(thing, place))
    most = min(place.most, DOUBTED) if thing.strayed else place.most
    thing.trust = min(here, thing.trust + regain, most)


def _strays(thing: Thing, place: Place) -> bool:
    """Whether what is in doubt, and has no colours to be known by, is found where no motion led.

    What bends has no shape that would tell it from an arm.
    """
    if thing.dyed or thing.large or thing.trust > DOUBTED:
        return False
    centre = thing.motion.centre[None]
    at = transform(place.pose, centre)[0]
    expected = transform_each(thing.motion.predictions(), centre)[:, 0]
    off = np.linalg.norm(expected - at, axis=1).min()
    return bool(off > ELSEWHERE * thing.model.radius)


def _move(thing: Thing, place: Place, verdict: Verdict) -> None:
    """Let the motion of a thing take in where it was found."""
    # What was found so in the frame before too has moved from there to here.
    scrap = thing.large and thing.last.points < SCRAP * thing.size and not thing.scanned
    if scrap or (place.anew and not thing.motion.fresh):
        thing.motion.begin(place.pose)
    else:
        thing.motion.add(place.pose, sure=thing.large or place.cost < DOUBTFUL)
    if thing.handy and well_seen(thing, verdict, thing.last.points):
        thing.motion.seen(thing.unit)


def well_seen(thing: Thing, verdict: Verdict, count: int) -> bool:
    """Whether a small thing with ``count`` points is seen well enough to tell whether it rests.

    What has turned or gone farther away shows fewer points, but in sight it tells that it moves.
    """
    if thing.motion.rests(thing.unit):
        return count > WELL * thing.size
    in_sight = verdict.visible > WELL and verdict.inliers > REGAINED
    return in_sight and count > HARDLY * thing.size


def _seen(thing: Thing, view: View, place: Place, verdict: Verdict) -> bool:
    """Whether the thing was found; one that was hidden must show itself clearly."""
    clear = place.cost < DOUBTFUL and verdict.inliers > REGAINED
    if view.lens is None and np.array_equal(place.pose, thing.motion.poses[-1]):
        clear = verdict.inliers > STAYED
    return verdict.found and (thing.missing == 0 or thing.large or clear)


def hides(thing: Thing, view: View, place: Place, found: Claim) -> bool:
    """Whether what was found hides a small thing, and is not the thing: it fits badly, and has
    hardly the colours that were painted, nor those of the known surface, another side's too.

    What is alone in the air hides nothing.
    """
    if not thing.dyed or place.cost < SOUND or place.whole:
        return False
    colour = view.colour(found.indices)
    if not thing.worn.unlike(colour):
        return False
    known = ColourHistogram.of(thing.model.colour[thing.model.hits >= SURE])
    return known.likeness(colour) < known.usual - LESS


def _lesson(thing: Thing, sighting: Sighting) -> Claim:
    """What the model may learn of what was found: no new points that something unlabelled explains,
    or of colours that the thing has not shown: what holds it may be where it bends."""
    view, place, found = sighting.view, sighting.place, sighting.found
    if place.whole or thing.large:
        return found
    keep = found.gap < NEW_SURFACE * thing.model.spacing
    new = np.flatnonzero(~keep)
    keep[new] = ~thing.strange(view.colour(found.indices[new]))
    if not thing.bends:
        keep[new] &= unexplained(thing, view, place, found.indices[new])
    return found.pick(keep)
