"""Beginning of a track from painted points, and corrections by a person."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import OtherMovers, Track, begin
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import claim, painted_with_flying
from pointbrush.tracking.steps.context import set_other_movers_around, tell_apart
from pointbrush.tracking.steps.pieces import painted_with_ground
from pointbrush.tracking.steps.predict import search_among
from pointbrush.tracking.steps.register import find


def begin_label(
    tracks: dict[int, Track], view: View, label: int, points: I64, noise: float
) -> None:
    """Put what the ``points`` (M,) of a frame show among the objects, its model in the world.

    ``noise`` metres of the depth there.
    """
    track = begin(view, label, points, noise, OtherMovers.none())
    track.painted = replace(
        track.painted,
        grounded=painted_with_ground(view, points),
        with_flying=painted_with_flying(view, points, track.unit),
    )
    tracks[label] = track
    set_other_movers_around(track, view, track.model.xyz)


def begin_anew(tracks: dict[int, Track], view: View, label: int, points: I64, noise: float) -> F64:
    """Learn an object from ``points`` (M,) alone; its pose (4, 4), which goes on where it was."""
    before = tracks[label]
    pose = before.motion.poses[-1]
    shift = np.eye(4)
    if len(points):
        old = transform(pose, before.model.centre[None])[0]
        shift[:3, 3] = view.xyz[points].mean(axis=0) - old
    pose = shift @ pose
    begin_label(tracks, view, label, points, noise)
    tell_apart(tracks, view, [label])
    track = tracks[label]
    track.model.xyz = transform(inverse(pose), track.model.xyz)
    track.motion.centre, track.motion.poses = track.model.centre, [pose]
    return pose


def corrected(track: Track, view: View, points: I64) -> F64 | None:
    """Learn from ``points`` (M,) that a person painted; the pose (4, 4), None where none fits."""
    options = track.options
    if (
        track.bends
        or track.large
        or track.frames_unseen
        or len(points) < options.update.correction_min_points
    ):
        return None
    fit = find(search_among(track, view, points))
    model, reach = track.model, options.update.new_surface_units * track.unit
    found = claim(view, points, fit.world, model.colour, track.weight, 2 * track.reach)
    if fit.cost > options.update.correction_max_cost or len(
        found.indices
    ) < options.update.correction_explained_share * len(points):
        return None
    model.drop(_denied(track, view, fit, points) & (model.hits < options.surface.sure_hits))
    back = inverse(fit.pose)
    eye = None if view.eye is None else transform(back, view.eye[None])[0]
    found = claim(view, points, transform(fit.pose, model.xyz), model.colour, 0.0, reach)
    xyz = transform(back, view.xyz[found.indices].astype(np.float64))
    model.gather(xyz, view.colour(found.indices), found.gap, found.nearest, eye, sure=True)
    track.motion.add(fit.pose)
    track.last = replace(track.last, points=len(points))
    track.size = max(track.size, float(len(points)))
    track.confidence, track.astray = 1.0, False
    return fit.pose


def _denied(track: Track, view: View, fit: Registration, points: I64) -> Mask:
    """Return which of the model a person did not paint though the sensor saw it: a hand's, say."""
    options = track.options.verdict
    painted = close_to(fit.world, view.xyz[points], options.surface_units * track.unit)
    denied = ~painted & track.model.facing(fit.pose[None], view.eye)[0]
    if view.lens is not None:
        denied &= ~view.hides(fit.world, options.hidden_units * track.unit)
    return np.asarray(denied)
