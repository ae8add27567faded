"""Evidence of a registered pose: residuals, occlusion, and presence of the track."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.columns import Columns, nearest_one, spans, toned
from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.compute.rigid import Target, carried, transform_each
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.sensors.camera import Pixels, pixel
from pointbrush.tracking.sensors.sights import Sight, all_of, any_of
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Claim


class Look(NamedTuple):
    """Sample points (M,) of the model at each of K poses.

    ``world`` (K, M, 3): positions; ``seen`` (K, M): mask of visible points, which face the sensor
    and are not occluded; ``through`` (K, M): mask of seen-through points, with a measurement behind
    them; ``facing`` (K,): share that faces the sensor.
    """

    world: F64
    seen: Mask
    through: Mask
    facing: F64


def look(
    track: Track, view: View, sample: I64, poses: F64, own: Sequence[I64] | None = None
) -> Look:
    """Project ``sample`` (M,) model points at ``poses`` (K, 4, 4) into the frame.

    ``own``: by sensor, directions of its range image in which measurements may be the object itself
    and do not occlude it.
    """
    world = transform_each(poses, track.model.xyz[sample])
    looks = []
    for number, sight in enumerate(view.sights):
        facing = track.model.facing(poses, sight.eye, sample)
        directions = None if own is None else own[number]
        looks.append((facing, *_seen_from(track, view, sight, world, facing, directions)))
    facing, seen, through = map(any_of, zip(*looks, strict=True))
    share = facing.sum(axis=1) / max(len(sample), 1)
    return Look(world, seen, through, share)


def _seen_from(
    track: Track, view: View, sight: Sight, world: F64, facing: Mask, own: I64 | None
) -> tuple[Mask, Mask]:
    """Mark the points (K, M, 3) that are ``facing`` a sensor and visible to it, and the
    seen-through ones; see ``look``."""
    options = track.options
    by = options.register.occlusion_units * track.unit
    if sight.lens is not None:
        return _compare_with_frame(
            sight.lens.pixels,
            view.T_lens_world,
            view.depth,
            world,
            facing,
            by,
            options.lens.nearest_m,
        )
    through = np.zeros(facing.shape, np.bool_)
    if sight.shade is None:
        return facing, through
    size = options.register.nearer_radii * track.model.radius
    hidden = sight.shade.hides(world.reshape(-1, 3), by, own, size)
    return facing & ~hidden.reshape(facing.shape), through


def costs_of(track: Track, target: Target, sample: I64, at: Look, scale: float) -> F64:
    """Return (K,) the mean squared distance, 0 to 1, of visible points in position and colour.

    Seen-through points of other sides count with the maximum distance.
    """
    options = track.options.register
    colour = track.model.colour[sample]
    total, count = _distances(at, colour, target.columns, options.pair_scales * scale)
    lean = options.unseen_weight * len(sample)
    return np.asarray((total + lean * options.unseen_cost) / (count + lean))


@compiled
def _compare_with_frame(
    lens: Pixels,
    T_lens_world: F64,
    image: F32,
    world: F64,
    facing: Mask,
    by: float,
    nearest_m: float,
) -> tuple[Mask, Mask]:
    """Mark the visible ones of the ``facing`` points (K, M, 3), and all seen-through points.

    Points in the picture are occluded or seen through if the depth ``image`` differs by more than
    ``by`` metres.
    """
    seen, through = np.zeros(facing.shape, np.bool_), np.zeros(facing.shape, np.bool_)
    for k in range(len(world)):
        for i in range(world.shape[1]):
            at = carried(T_lens_world, world[k, i, 0], world[k, i, 1], world[k, i, 2])
            cell, depth = pixel(lens, at, nearest_m)
            if cell >= 0:
                seen[k, i] = facing[k, i] and not image[cell] < depth - by
                through[k, i] = image[cell] > depth + by
    return seen, through


@compiled
def _distances(at: Look, colour: F32, grid: Columns, most: float) -> tuple[F64, F64]:
    """Return sums of squared distances of visible points, in ``most`` metres, and their numbers.

    Other points that were seen through count with the maximum distance.
    """
    world, seen, through, _ = at
    total, count, room = np.zeros(len(world)), np.zeros(len(world)), spans(grid)
    last = np.full(world.shape[1], -1)
    for k in range(len(world)):
        for i in range(world.shape[1]):
            if seen[k, i]:
                point = (world[k, i, 0], world[k, i, 1], world[k, i, 2])
                tint = toned(grid, colour, i)
                # The nearest point at the last pose bounds the search.
                square, near = nearest_one(grid, point, tint, most, room, last[i])
                last[i] = near
                total[k] += square / (most * most) if near >= 0 else 1.0
                count[k] += 1.0
            elif through[k, i]:
                total[k] += 1.0
                count[k] += 1.0
    return total, count


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """Agreement of a registered model with a frame.

    ``found``: whether the object is present; ``inliers``: matched share of the visible model;
    ``hidden`` and ``through`` (M,): masks of occluded and of seen-through model points;
    ``visible``: share of the facing model that is not occluded.
    """

    found: bool
    inliers: float
    confidence: float
    hidden: Mask
    through: Mask
    visible: float


def _hidden(sides: Sequence[Mask], occluded: Sequence[Mask]) -> Mask:
    """Mark the points (M,) that no sensor sees.

    Each sensor does not face it or has it ``occluded``; a point that faces none is occluded for
    all.
    """
    seen = any_of(a & ~b for a, b in zip(sides, occluded, strict=True))
    return ~seen & (any_of(sides) | all_of(occluded))


def judge(
    track: Track, view: View, pose: F64 | None, world: F64 | None, found: Claim | None
) -> Verdict:
    """Compare the model at ``pose`` (4, 4), its points at ``world`` (M, 3), with its claim.

    The object is not found if one of them is None.
    """
    options = track.options.verdict
    n = len(track.model.xyz)
    nothing = np.zeros(n, np.bool_)
    if pose is None or world is None or found is None:
        return Verdict(False, 0.0, 0.0, nothing, nothing, 0.0)
    sides = [track.model.facing(pose[None], sight.eye)[0] for sight in view.sights]
    facing = any_of(sides)
    matched = nothing.copy()
    if len(found.indices):
        reach = options.surface_units * track.unit
        matched[found.nearest[found.gap < reach]] = True
        rest = np.flatnonzero(~matched)
        matched[rest] = close_to(world[rest], view.xyz[found.indices], reach)
    hidden = through = nothing
    if view.lens is not None:
        hidden = _hidden(sides, view.hidden_from(world, options.hidden_units * track.unit))
        beyond = view.seen_through_from(world, options.seen_through_units * track.unit)
        through = any_of(a & b for a, b in zip(sides, beyond, strict=True)) & ~matched
    elif view.shaded:
        shades = [sight.shade for sight in view.sights if sight.shade is not None]
        far = [shade.hides(world, options.hidden_units * track.unit) for shade in shades]
        hidden = _hidden(sides, far)
    hidden = hidden & ~matched
    expected = facing & ~hidden
    if expected.sum() < options.min_facing_points:
        expected = ~hidden
    inliers = float(matched[expected].mean()) if expected.any() else 0.0
    visible = float(expected.sum() / max(1, facing.sum()))
    enough = len(found.indices) >= max(options.min_points, options.min_size_share * track.size)
    # Occlusions in lidar scans are too coarse to predict all visible points.
    much = track.scanned and len(found.indices) > options.remaining_share * track.last.points
    good = enough and (inliers > options.present_share or much)
    confidence = float(np.clip(inliers * min(1.0, options.min_trust_share + visible), 0, 1))
    return Verdict(good, inliers, confidence, hidden, through, visible)
