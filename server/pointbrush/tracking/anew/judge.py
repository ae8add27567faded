"""Judge: whether a labelled track is there, and its confidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.anew.label import Share
from pointbrush.tracking.anew.track import Track
from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.confidence import Evidence, likelihood
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.verdict import Verdict, judge


@dataclass(frozen=True, eq=False)
class Judged:
    """A track's ``verdict``, whether it is ``seen``, and this frame's ``likelihood``."""

    seen: bool
    verdict: Verdict
    likely: float = 0.0
    evidence: Evidence | None = None


def judged(track: Track, view: View, fit: Registration | None, share: Share | None) -> Judged:
    """Return the judgement of a labelled track."""
    if fit is None or share is None:
        return Judged(False, judge(track.as_auto, view, None, None, None))
    options, core = track.options, share.claim.pick(share.claim.gap < 2.2 * track.reach)
    verdict = judge(track.as_auto, view, fit.pose, fit.world, core)
    clear = (
        fit.cost < options.update.motion_cost and verdict.inliers > options.update.reappear_share
    )
    seen = verdict.found and (track.frames_unseen == 0 or clear)
    if not seen or _is_occluder(track, view, fit, share, clear):
        return Judged(False, verdict)
    features = _evidence(track, view, fit, share, verdict)
    return Judged(True, verdict, likelihood(features, options=options.confidence), features)


def _is_occluder(track: Track, view: View, fit: Registration, share: Share, clear: bool) -> bool:
    """Return whether the points hide the object: they fit poorly and have other colours."""
    options = track.options.update
    fits = fit.cost < options.teach_cost or clear
    if not track.has_colour_key or fits or share.isolated:
        return False
    colour = view.colour(share.claim.indices)
    if not track.appearance.unlike(colour):
        return False
    sure = track.model.hits >= track.options.surface.sure_hits
    known = ColourHistogram.of(track.model.colour[sure], track.options.appearance)
    return known.likeness(colour) < known.usual - options.hiding_log_colour


def _evidence(
    track: Track, view: View, fit: Registration, share: Share, verdict: Verdict
) -> Evidence:
    found, count = share.claim, max(len(share.claim.indices), 1)
    core = found.pick(found.gap < 2.2 * track.reach)
    m = max(len(core.indices), 1)
    own = view.xyz[found.indices].astype(np.float64)
    touching = track.options.claim.touching_units * track.unit
    rest = share.beside
    beside = close_to(view.xyz[rest].astype(np.float64), own, touching).sum() if len(rest) else 0
    sure = track.model.hits[core.nearest] >= track.options.surface.sure_hits
    return Evidence(
        inliers=verdict.inliers,
        sure=float(sure.mean()) if len(sure) else 0.0,
        gap=float(core.gap.sum() / m / track.reach),
        cost=float(core.cost.sum() / m / track.reach),
        fit=fit.cost,
        size=count / max(track.size, 1.0),
        change=count / max(track.last.points, 1),
        grown=1.0 - m / count,
        isolated=share.isolated,
        share=m / max(len(fit.moving), 1),
        appearance=0.0,
        usual=track.usual_cost,
        points=count,
        soft=track.soft,
        coarse=track.unit / max(track.model.radius, track.unit),
        beside=float(beside / count),
    )
