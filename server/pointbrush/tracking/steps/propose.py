"""Pose hypotheses beyond the predictions, from clusters of moving points by colour and size."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from pointbrush.tracking.compute.graph import pieces
from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.compute.rigid import Target, transform
from pointbrush.tracking.interface import F32, F64, Mask
from pointbrush.tracking.model.surface import Model
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options.steps import ProposalOptions

AS_IT_WAS = np.eye(3)[None]
"""No rotation (1, 3, 3)."""
ALL_WAYS = Rotation.create_group("O").as_matrix()
"""Rotations (24, 3, 3) within 63 degrees of any rotation."""
OPPOSITE, ALONG = -0.9999, 1e-3
"""Cosine under which two directions are opposite, and sine under which they are the same: the axis
from one to the other is not told by their product."""


def proposals(track: Track, target: Target, pose: F64) -> list[F64]:
    """Return candidate poses (4, 4) for an object with unknown motion.

    Positions are the one of ``pose`` and the most likely clusters of the target.  Rotations are the
    one of ``pose``, turns about each axis in both directions, and alignments of the longest axes of
    object and cluster in both directions.
    """
    options = track.options.propose
    model = track.model
    world = transform(pose, model.xyz)
    middle = world.mean(axis=0)
    axis, length = _axis(world)
    result = [*_moved(pose, middle, middle, _turns(options.turn_deg))]
    for centre, points in _clusters(track, target):
        turns = [AS_IT_WAS, _turns(options.turn_deg)]
        along, other = _axis(points) if length > options.long_ratio else (axis, 1.0)
        if other > options.long_ratio:
            turns += [_turn(axis, sign * along)[None] for sign in (1.0, -1.0)]
        result += [*_moved(pose, middle, centre, np.concatenate(turns))]
    return result


def _turns(degrees: float) -> F64:
    """Return the rotations (6, 3, 3) by some degrees about each axis, in both directions."""
    vectors = [sign * np.radians(degrees) * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    return np.asarray(Rotation.from_rotvec(vectors).as_matrix())


def shifts(model: F64, target: F64, pose: F64, unit: float, options: ProposalOptions) -> list[F64]:
    """Return translations (4, 4) of ``pose`` that match most points of a model (M, 3) and target.

    A vehicle may have moved far, with nearly the same rotation.
    """
    world = transform(pose, model)
    both = np.vstack([target, world])
    step = max(
        options.vote_step_units * unit, float(np.ptp(both, axis=0).max()) / options.max_steps_across
    )
    cells = np.unique(np.floor(target / step).astype(np.int64), axis=0)
    votes = (cells[:, None] - np.floor(world / step).astype(np.int64)).reshape(-1, 3)
    lo = votes.min(axis=0)
    size = np.ptp(votes, axis=0) + 1
    number, count = np.unique((votes - lo) @ [size[1] * size[2], size[2], 1], return_counts=True)
    likely = number[np.argsort(-count, kind="stable")[: options.vote_window_steps]]
    kept = np.zeros((1, 3), np.int64)
    for shift in np.stack(np.unravel_index(likely, size), axis=1) + lo:
        if (
            len(kept) <= options.voted_shifts
            and (np.abs(kept - shift).max(axis=1) > options.same_shift_steps).all()
        ):
            kept = np.vstack([kept, shift])
    found = np.repeat(pose[None], len(kept), axis=0)
    found[:, :3, 3] += kept * step
    return list(found[1:])


def nudges(model: Model, pose: F64, options: ProposalOptions) -> list[F64]:
    """Return poses (4, 4) near ``pose``: small turns about each axis, shifts along the longest."""
    world = transform(pose, model.xyz)
    middle = world.mean(axis=0)
    axis, _ = _axis(world)
    centres = [middle + step * model.radius * axis for step in options.slide_radii]
    slid = [_moved(pose, middle, there, AS_IT_WAS)[0] for there in centres]
    return [*_moved(pose, middle, middle, _turns(options.turn_deg)), *slid]


def turned_at(model: Model, pose: F64, middle: F64) -> F64:
    """Return poses (24, 4, 4) with the model's centre at ``middle``, in all orientations."""
    at = transform(pose, model.xyz).mean(axis=0)
    return _moved(pose, at, middle, ALL_WAYS)


def alike(model: Model, colour: F32, options: ProposalOptions) -> Mask:
    """Mark the colours (M, 3) that are similar to one of the model's."""
    palette = model.colour[:: max(1, len(model.colour) // options.palette_points)]
    return close_to(colour, palette, options.alike_colour)


def _clusters(track: Track, target: Target) -> list[tuple[F64, F64]]:
    """Return centres (3,) and points (M, 3) of the most likely clusters of the target.

    Isolated clusters come first, followed by the densest regions.
    """
    options = track.options.propose
    model, points = track.model, target.xyz
    if target.weight > 0:
        points = points[alike(model, target.colour, options)]
    found = _alone(track, points) if track.hand_sized else []
    radius = max(model.radius, options.min_radius_m)
    while len(points) >= options.min_cluster_points and len(found) < options.clusters:
        some = points[:: max(1, len(points) // options.seeds)]
        near = cKDTree(points).query_ball_point(
            some, options.crowd_radii * radius, return_length=True
        )
        centre = some[int(np.argmax(near))]
        for _ in range(options.mean_shift_rounds):
            inside = np.linalg.norm(points - centre, axis=1) < options.cluster_radii * radius
            if not inside.any():
                break
            centre = points[inside].mean(axis=0)
        inside = np.linalg.norm(points - centre, axis=1) < options.cluster_radii * radius
        if inside.sum() < options.min_cluster_points:
            break
        found.append((centre, points[inside]))
        points = points[~inside]
    return found


def _alone(track: Track, points: F64) -> list[tuple[F64, F64]]:
    """Return centres and points of components no larger than the model, the largest first."""
    options, model, unit = track.options, track.model, track.unit
    if len(points) < options.propose.min_cluster_points:
        return []
    piece = pieces(points, unit, options=options.link)
    size = np.bincount(piece)
    found = []
    for one in np.argsort(-size, kind="stable")[: 2 * options.propose.clusters].tolist():
        mine = points[piece == one]
        middle = mine.mean(axis=0)
        far = float(np.linalg.norm(mine - middle, axis=1).max())
        if (
            len(mine) >= options.propose.min_cluster_points
            and far < options.propose.closed_radii * model.radius
        ):
            found.append((middle, mine))
    return found[: options.propose.clusters]


def _axis(xyz: F64) -> tuple[F64, float]:
    """Return the longest axis, and the ratio of its length to the next one's."""
    if len(xyz) < 3:
        return np.array([1.0, 0.0, 0.0]), 1.0
    off = xyz.T - xyz.mean(axis=0)[:, None]
    values, vectors = np.linalg.eigh((off @ off.T) * (1.0 / (len(xyz) - 1)))
    spread = float(np.sqrt(max(values[2], 1e-12) / max(values[1], 1e-12)))
    return vectors[:, 2], spread


def _turn(a: F64, b: F64) -> F64:
    """Return the minimal rotation (3, 3) of the unit vector ``a`` to ``b``."""
    v, c = np.cross(a, b), float(a @ b)
    if c < OPPOSITE:
        side = np.cross(a, [1.0, 0.0, 0.0])
        if np.linalg.norm(side) < ALONG:
            side = np.cross(a, [0.0, 1.0, 0.0])
        side /= np.linalg.norm(side)
        return np.asarray(2 * np.outer(side, side) - np.eye(3))
    K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.asarray(np.eye(3) + K + K @ K / (1 + c))


def _moved(pose: F64, middle: F64, centre: F64, turns: F64) -> F64:
    """Return (K, 4, 4) ``pose`` rotated by ``turns`` (K, 3, 3) and moved.

    The rotation is about ``middle`` (3,), which moves to ``centre`` (3,).
    """
    T = np.zeros((len(turns), 4, 4))
    T[:, :3, :3] = turns
    T[:, :3, 3] = centre - turns @ middle
    T[:, 3, 3] = 1.0
    return np.asarray(T @ pose)
