"""Update of a track: start or correction from painted points, and learning in each frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.motion import Motion
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.surface import Model
from pointbrush.tracking.model.track import OtherMovers, Track, begin
from pointbrush.tracking.sensors.sights import any_of
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import LabelledPoints
from pointbrush.tracking.steps.claim import Claim, claim, painted_with_flying
from pointbrush.tracking.steps.context import set_other_movers_around, update_distinct_colours
from pointbrush.tracking.steps.ground_contact import painted_with_ground
from pointbrush.tracking.steps.predict import search_among, target_of
from pointbrush.tracking.steps.register import bent, find
from pointbrush.tracking.steps.verdict import Verdict


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """A track registered (``fit``) in a ``view``, with its points ``given``.

    ``verdict``: agreement of the fit with the sensor's measurements.
    """

    view: View
    fit: Registration
    given: LabelledPoints
    verdict: Verdict


def positions_to_exclude(
    tracks: Mapping[int, Track], fits: Mapping[int, Registration], view: View
) -> F64:
    """Return (M, 3) positions of objects to exclude from the background, claimed or not."""
    slow = {n: t for n, t in tracks.items() if t.motion.slow(t.unit)}
    there = [fits[n].world for n in fits if n in view.labels and n in slow]
    if view.lens is None:
        # Occluded and absent objects are indistinguishable: an object may be at its last place.
        hidden = [t for n, t in slow.items() if n not in view.labels and not t.lost]
        there += [transform(t.motion.poses[-1], t.model.xyz) for t in hidden]
    else:
        there += [_hidden_at_rest(t, view) for t in tracks.values()]
    return np.concatenate([np.empty((0, 3)), *there])


def _hidden_at_rest(track: Track, view: View) -> F64:
    """Return (M, 3) resting positions of an object, without seen-through ones."""
    if track.motion.rested is None:
        return np.empty((0, 3))
    world = transform(track.motion.rested, track.model.xyz)
    return np.asarray(world[view.hides(world, -track.options.verdict.hidden_units * track.unit)])


def learn(track: Track, observation: Observation) -> None:
    """Update the model with the found points: extend a rigid model, rebuild a bending one."""
    found, grown = observation.given.claim, observation.given.grown
    if observation.verdict.confidence > track.options.update.size_matched_share:
        track.size = max(track.size, float(len(found.indices) + len(grown)))
    was_rigid = not track.bends
    note_looseness(track, observation)
    if track.bends:
        _rebuild_model(track, observation)
    else:
        _gather(track, observation, was_rigid)


def _rebuild_model(track: Track, observation: Observation) -> None:
    """Rebuild a bending model from the found points and the hidden part of the old model."""
    options = track.options
    view, fit, points = observation.view, observation.fit, observation.given.points
    back = inverse(fit.pose)
    xyz = transform(back, view.xyz[points].astype(np.float64))
    unseen = observation.verdict.hidden
    if track.scanned:  # occlusions in lidar scans are known too coarsely
        unseen = unseen | ~close_to(
            fit.world, view.xyz[points], options.verdict.surface_units * track.unit
        )
    old = np.flatnonzero(unseen & (track.model.misses < options.update.forgotten_frames))
    before = track.model
    new = Model.of(
        xyz,
        view.colour(points),
        _eyes_of(back, view, points),
        before.spacing,
        options.surface,
        options.surface.max_points_bent,
    )
    new.xyz = np.vstack([new.xyz, transform(back, fit.world[old])])
    new.colour = np.vstack([new.colour, before.colour[old]])
    new.seen = np.vstack([new.seen, before.seen[old]])
    new.hits = np.append(new.hits, before.hits[old]).astype(np.float32)
    new.misses = np.append(new.misses, before.misses[old] + 1).astype(np.float32)
    track.model = new


def _gather(track: Track, observation: Observation, was_rigid: bool) -> None:
    """Add found points on and beside a rigid model to it, and drop points seen through."""
    view, fit, given = observation.view, observation.fit, observation.given
    back = inverse(fit.pose)
    number = track.model.miss(observation.verdict.through)
    if not was_rigid:  # the claim refers to the deformed model
        number[:] = -1
    claim = _updated_claim(track, observation, number)
    if not given.isolated:
        claim = claim.pick(claim.cost < 2 * track.reach)
    if not track.painted.flat:  # Ground beside known surface is no new surface.
        claim = claim.pick(
            ~view.low[claim.indices]
            | (claim.gap < track.options.surface.new_spacings * track.model.spacing)
        )
    xyz = transform(back, view.xyz[claim.indices].astype(np.float64))
    colour = view.colour(claim.indices)
    # Objects scanned by a moving lidar show new sides and are not held.
    sure = track.distinct(colour) | (given.isolated or view.roams)
    own_eye = _eyes_of(back, view, claim.indices)
    track.model.gather(xyz, colour, claim.gap, claim.nearest, own_eye, sure)


def _updated_claim(track: Track, observation: Observation, number: I64) -> Claim:
    """Return the claim of the updated model on the object's points.

    Points keep their model point unless it was removed.  ``number`` (M,): new number of each model
    point, -1 for removed ones.
    """
    options = track.options.update
    view, fit, given = observation.view, observation.fit, observation.given
    found = given.claim
    reach = (
        options.new_surface_units if given.isolated or track.scanned else options.teach_units
    ) * track.unit
    if given.end_on:
        reach = track.options.track.tall_m
    now = number[found.nearest]
    kept = (now >= 0) & (found.gap < reach)
    rest = np.concatenate([found.indices[~kept], given.grown])
    world = transform(fit.pose, track.model.xyz)
    new = claim(view, rest, world, track.model.colour, track.weight, reach)
    return Claim(
        np.concatenate([found.indices[kept], new.indices]),
        np.concatenate([found.cost[kept], new.cost]),
        np.concatenate([found.gap[kept], new.gap]),
        np.concatenate([now[kept], new.nearest]),
    )


def _eyes_of(back: F64, view: View, points: I64) -> F64 | None:
    """Return ``View.eyes_of`` some points in the model's coordinates."""
    eyes = view.eyes_of(points)
    return None if eyes is None else transform(back, eyes)


def note_looseness(track: Track, observation: Observation) -> None:
    """Update the share of found points that a rigid model does not explain."""
    options = track.options.strain
    given, verdict = observation.given, observation.verdict
    found, grown = given.claim, given.grown
    total = len(found.indices) + len(grown)
    unlike = 0 if given.isolated else len(grown)
    loose = (unlike + np.count_nonzero(found.gap > options.unexplained_units * track.unit)) / max(
        total, 1
    )
    # A mostly occluded object has little evidence about the rest of it.
    rate = options.share_rate * (verdict.visible if track.hand_sized else 1.0)
    share = track.bending.share
    share += rate * (max(loose, 1 - verdict.inliers) - share)
    track.bending = replace(track.bending, share=share)


def note_strain(track: Track, observation: Observation) -> None:
    """Update the share of a small object that only bending explains."""
    options = track.options
    if track.stiff and _tests_bending(track, observation):
        most = (
            np.inf
            if track.size > options.track.dense_points
            else options.strain.max_frame_ratio * options.track.soft_strain
        )
        now = min(bent_share(track, observation), most)
        strain = track.bending.strain
        strain += options.strain.strain_rate * (now - strain)
        track.bending = replace(track.bending, strain=strain)


def bent_share(track: Track, observation: Observation) -> float:
    """Return the share of the known surface that bending explains and a rigid motion does not."""
    options = track.options
    model, view, fit = track.model, observation.view, observation.fit
    facing = any_of(model.facing(fit.pose[None], sight.eye)[0] for sight in view.sights)
    known = np.flatnonzero(
        facing & ~observation.verdict.hidden & (model.hits >= options.surface.sure_hits)
    )
    if len(known) < options.strain.min_known_points:
        return 0.0
    some = known[:: -(-len(known) // options.strain.bent_points)]
    world, colour = fit.world[some], model.colour[some]
    target = target_of(view, fit.near, track.weight, options.strain.target_points)
    far = options.strain.far_units * track.unit
    off = target.nearest(world, colour, far)[0] > options.strain.off_units * track.unit
    if track.motion.slow(track.unit):
        off[off] = ~_beside_another(view, world[off], observation.given.points, far)
    if off.mean() < options.strain.min_off_share:
        return 0.0
    moved = bent(track, world, colour, target)[off]
    residual = target.nearest(moved, colour[off], far)[0]
    return float(np.count_nonzero(residual < options.strain.on_units * track.unit) / len(off))


def _tests_bending(track: Track, observation: Observation) -> bool:
    """Return whether to test in this frame if an object bends: seldom without evidence.

    A dense object fits well as long as it is stiff.
    """
    options = track.options
    is_suspected = track.bending.strain > options.strain.hint_share * options.track.soft_strain
    is_suspected = is_suspected or (
        observation.fit.cost > options.strain.loose_cost and track.size > options.track.dense_points
    )
    return (
        is_suspected or (observation.view.number + track.label) % options.strain.stiff_frames == 0
    )


def _beside_another(view: View, world: F64, own: I64, step: float) -> Mask:
    """Mark the object's points (M, 3) beside the outline of a surface ``step`` metres nearer.

    Surface behind an outline is measured poorly at the rim, which would look like bending.  ``own``
    (N,): the object's points in the frame, which do not occlude it.
    """
    options = view.options.strain
    if view.lens is None:
        return np.zeros(len(world), np.bool_)
    steps = np.array(
        [
            row * view.lens.shape[1] + column
            for row in options.outline_offsets_px
            for column in options.outline_offsets_px
        ]
    )
    mine, found = view.marked(own), np.zeros(len(world), np.bool_)
    for cell, depth in view.project(world):
        around = np.clip(cell[:, None] + steps, 0, len(view.depth) - 1)
        with np.errstate(invalid="ignore"):
            nearer = view.depth[around] < depth[:, None] - step
        found |= (nearer & ~mine[around]).any(axis=1)
    return found


def begin_label(
    tracks: dict[int, Track], view: View, label: int, points: I64, noise: float
) -> None:
    """Start a track from the ``points`` (M,) of a frame, with its model in the world.

    ``noise``: depth noise there (m).
    """
    track = begin(view, label, points, noise, OtherMovers.none())
    track.painted = replace(
        track.painted,
        grounded=painted_with_ground(view, points),
        with_flying=painted_with_flying(view, points, track.unit),
    )
    tracks[label] = track
    set_other_movers_around(track, view, track.model.xyz)


def restart_track(
    tracks: dict[int, Track], view: View, label: int, points: I64, noise: float
) -> F64:
    """Restart an object from ``points`` (M,); return its pose (4, 4), continuing the last one."""
    before = tracks[label]
    pose = before.motion.poses[-1]
    shift = np.eye(4)
    if len(points):
        old = transform(pose, before.model.centre[None])[0]
        shift[:3, 3] = view.xyz[points].mean(axis=0) - old
    pose = shift @ pose
    begin_label(tracks, view, label, points, noise)
    update_distinct_colours(tracks, view, [label])
    track = tracks[label]
    track.model.xyz = transform(inverse(pose), track.model.xyz)
    track.motion = Motion(track.options.search, track.model.centre, (pose,))
    return pose


def correct_track(track: Track, view: View, points: I64) -> F64 | None:
    """Update a track from painted ``points`` (M,); return the pose (4, 4), None: none fits."""
    options = track.options
    if not track.rigid or track.frames_unseen or len(points) < options.update.correction_min_points:
        return None
    fit = find(search_among(track, view, points))
    model, reach = track.model, options.update.new_surface_units * track.unit
    found = claim(view, points, fit.world, model.colour, track.weight, 2 * track.reach)
    if fit.cost > options.update.correction_max_cost or len(
        found.indices
    ) < options.update.correction_explained_share * len(points):
        return None
    model.drop(
        _unpainted_model_points(track, view, fit, points) & (model.hits < options.surface.sure_hits)
    )
    back = inverse(fit.pose)
    found = claim(view, points, transform(fit.pose, model.xyz), model.colour, 0.0, reach)
    xyz = transform(back, view.xyz[found.indices].astype(np.float64))
    eyes = _eyes_of(back, view, found.indices)
    model.gather(xyz, view.colour(found.indices), found.gap, found.nearest, eyes, sure=True)
    track.motion = track.motion.add(fit.pose)
    track.last = replace(track.last, points=len(points))
    track.size = max(track.size, float(len(points)))
    track.confidence, track.astray = 1.0, False
    return fit.pose


def _unpainted_model_points(track: Track, view: View, fit: Registration, points: I64) -> Mask:
    """Mark the model points that are visible but not painted, such as points of a hand."""
    options = track.options.verdict
    painted = close_to(fit.world, view.xyz[points], options.surface_units * track.unit)
    sides = [track.model.facing(fit.pose[None], sight.eye)[0] for sight in view.sights]
    if view.lens is None:
        return np.asarray(~painted & any_of(sides))
    hidden = view.hidden_from(fit.world, options.hidden_units * track.unit)
    return ~painted & any_of(side & ~far for side, far in zip(sides, hidden, strict=True))
