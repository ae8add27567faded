"""Update: the next value of a track, from its fit, labels and judgement."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.anew.judge import Judged
from pointbrush.tracking.anew.label import Share
from pointbrush.tracking.anew.priors import NextOptions
from pointbrush.tracking.anew.register import off_predictions
from pointbrush.tracking.anew.track import Track, with_others
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import Mask
from pointbrush.tracking.model.motion import Motion
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.surface import CarvingView, Model, remember
from pointbrush.tracking.model.track import LastObservation
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Claim, claim


def unseen(track: Track, continue_lost: bool) -> Track:
    """Return the track after a frame without it."""
    count = track.frames_unseen + 1
    return replace(
        track,
        frames_unseen=count,
        motion=track.motion.unseen(),
        lost=count > track.options.update.lost_frames and not continue_lost,
        confidence=max(0.0, track.confidence - track.options.confidence.regain),
    )


def updated(
    track: Track,
    view: View,
    fit: Registration,
    share: Share,
    judged: Judged,
    cap: float,
    moved: bool,
    options: NextOptions,
) -> Track:
    """Return the track after a frame with it; ``moved``: it was found far from its predictions."""
    update, alone = track.options.update, share.isolated
    teaches = fit.cost < update.teach_cost
    regain = track.confidence + track.options.confidence.regain
    astray = (
        moved
        and not track.has_colour_key
        and off_predictions(track, fit) > (update.astray_radii * track.model.radius)
    )
    cap = min(cap, update.astray_confidence) if astray and not alone else cap
    found = share.claim
    after = replace(
        track,
        frames_unseen=0,
        confidence=min(judged.likely, regain, cap),
        motion=_motion(track, fit, judged, moved, len(found.indices)),
        last=LastObservation(len(found.indices), fit.alternatives_failed, judged.evidence),
        frames_alone=track.frames_alone + (alone and teaches),
        size=max(track.size, float(len(found.indices)))
        if judged.verdict.confidence > update.size_matched_share
        else track.size,
    )
    if alone and teaches and judged.evidence is not None:
        more = judged.evidence.cost - track.usual_cost
        after = replace(after, usual_cost=track.usual_cost + update.usual_cost_rate * more)
    if teaches:
        after = replace(
            after,
            model=_learnt(track, view, fit, share, judged.verdict.through, options),
            views=_viewed(track, view, fit),
        )
    return with_others(after, view, share.beside, fit.box)


def _motion(track: Track, fit: Registration, judged: Judged, moved: bool, count: int) -> Motion:
    options = track.options
    if moved and not track.motion.is_unknown:
        motion = track.motion.begin(fit.pose)
    else:
        motion = track.motion.add(fit.pose, sure=fit.cost < options.update.motion_cost)
    verdict = judged.verdict
    if motion.rests(track.unit):
        clear = count > options.update.clear_share * track.size
    else:
        clear = (
            verdict.visible > options.update.clear_share
            and verdict.inliers > options.update.reappear_share
            and count > options.track.hardly_share * track.size
        )
    trusted = min(judged.likely, track.confidence + 0.15) >= options.smoothing.sure
    return motion.seen(track.unit) if clear and trusted else motion


def _viewed(track: Track, view: View, fit: Registration) -> tuple[CarvingView, ...]:
    views = list(track.views)
    remember(views, view, fit.pose, fit.world)
    return tuple(views)


def _learnt(
    track: Track, view: View, fit: Registration, share: Share, through: Mask, options: NextOptions
) -> Model:
    """Return the model with hits, misses and new surface of a frame."""
    model = _copy(track.model)
    number = model.miss(through)
    keep = _teaching(track, view, share, options)
    found = share.claim.pick(keep)
    now = number[found.nearest]
    gone = now < 0
    if gone.any():
        world = transform(fit.pose, model.xyz)
        far = track.options.update.new_surface_units * track.unit
        new = claim(view, found.indices[gone], world, model.colour, track.weight, far)
        found = Claim(
            np.concatenate([found.indices[~gone], new.indices]),
            np.concatenate([found.cost[~gone], new.cost]),
            np.concatenate([found.gap[~gone], new.gap]),
            np.concatenate([now[~gone], new.nearest]),
        )
    else:
        found = replace(found, nearest=now)
    back = inverse(fit.pose)
    colour = view.colour(found.indices)
    eye = None if view.eye is None else transform(back, view.eye[None])[0]
    sure = track.distinct(colour) | share.isolated
    xyz = transform(back, view.xyz[found.indices].astype(np.float64))
    model.gather(xyz, colour, found.gap, found.nearest, eye, sure)
    return model


def _teaching(track: Track, view: View, share: Share, options: NextOptions) -> Mask:
    """Mark the points (M,) that teach: surely the track's, and away from other movers if new."""
    found, update = share.claim, track.options.update
    on = found.gap < track.options.surface.new_spacings * track.model.spacing
    if share.isolated:
        far = update.new_surface_units * track.unit if track.extent_known else np.inf
        return (share.posterior > 0.5) & (on | (found.gap < far))
    sure = share.posterior > options.energy.learn_posterior
    new = sure & (found.cost < 2 * track.reach) & ~share.near_other
    new &= ~track.strange(view.colour(found.indices))
    return np.asarray((on & (share.posterior > 0.5)) | new)


def _copy(model: Model) -> Model:
    return replace(
        model, hits=model.hits.copy(), misses=model.misses.copy(), seen=model.seen.copy()
    )
