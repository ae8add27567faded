"""Fit of a moving object: sides frame by frame, a smooth path through them, and yaws along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting.observation import View
from pointbrush.fitting.options import FitOptions
from pointbrush.fitting.parked import (
    Level,
    best_sides,
    confidence_of,
    rays_of,
    shell,
    world_centre,
)
from pointbrush.fitting.priors import SizePrior
from pointbrush.fitting.sides import Sides, find_sides, likely_size
from pointbrush.fitting.trajectory import smooth_angles, smooth_path, speeds
from pointbrush.fitting.yaw import outline_yaw, wrapped

Floats = NDArray[np.float64]
AXLE = 0.28
"""Distance of the fixed axle behind the middle, as a share of a vehicle's length."""
SLOW = 1.0
"""Metres per second below which a vehicle's path hardly constrains its yaw."""
OUTLINE_WITHIN = np.radians(12.0)
"""Maximum angle, in radians, between the direction of the path and the outline's."""


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Initial estimate from single frames.

    ``sides``: sides of each frame; sizes (k, 3) and ``priors`` chosen there; path (k, 2) of the
    centres, the ground (k,) below them, and whether the object ``moves``.
    """

    sides: list[Sides]
    sizes: Floats
    priors: list[SizePrior]
    path: Floats
    ground: list[float | None]
    moves: bool


def start_of(
    views: list[View], posed: bool, priors: Sequence[SizePrior], options: FitOptions
) -> Start:
    """Fit each frame separately, and decide whether the object moves."""
    sides, sizes, chosen, centres, ground = [], [], [], [], []
    for view in views:
        eyes, ends = rays_of([view])
        found, size, prior = best_sides(view.xyz, eyes, ends, view.ground, priors, options)
        sides.append(found)
        sizes.append(size)
        chosen.append(prior)
        centres.append(world_centre(found, size, options))
        ground.append(view.ground)
    times = np.array([view.time for view in views])
    places = np.array(centres)[:, :2]
    noise = np.full((len(views), 2), 0.3)
    yaws = np.array([each.yaw for each in sides])
    path = smooth_path(places, noise, yaws, times, options.acceleration)
    moves = posed and _moves(views, path, options)
    return Start(sides, np.array(sizes), chosen, path, ground, moves)


def _moves(views: list[View], path: Floats, options: FitOptions) -> bool:
    """Return whether points fill fewer cells after compensation of the motion along the path."""
    if float(np.linalg.norm(path - path[0], axis=1).max()) < options.moved:
        return False
    still, taken = (
        _filled([v.xyz[:, :2] - by for v, by in zip(views, offsets, strict=True)], options)
        for offsets in (np.zeros_like(path), path - path[0])
    )
    return taken < options.sharper * still


def _filled(parts: list[Floats], options: FitOptions) -> int:
    cells = np.floor(np.concatenate(parts) / options.sharp_cell).astype(np.int64)
    return len(np.unique(cells[:, 0] * 1_000_003 + cells[:, 1]))


def fit_moving(
    views: list[View], start: Start, priors: Sequence[SizePrior], options: FitOptions
) -> Level:
    """Fit a common size and a pose for each frame."""
    times = np.array([view.time for view in views])
    prior = _class(start, priors)
    size = np.median(start.sizes, axis=0)
    path, sides = start.path, start.sides
    yaws = np.array([each.yaw for each in sides])
    for _ in range(options.rounds):
        yaws = _directions(views, start, path, yaws, times, prior, size, options)
        sides = [
            _sides(view, float(yaw), ground, prior, options)
            for view, yaw, ground in zip(views, yaws, start.ground, strict=True)
        ]
        size, _ = likely_size(sides, prior, options)
        places = np.array([world_centre(each, size, options)[:2] for each in sides])
        slack = np.array([each.slack(size)[:2] for each in sides])
        noise = options.side_noise + slack / 2
        path = smooth_path(places, noise, yaws, times, options.acceleration)
    heights = np.array([each.low[2] for each in sides]) + size[2] / 2
    centres = np.column_stack([path, heights])
    sure = np.array(
        [confidence_of(each, size, len(v.xyz)) for each, v in zip(sides, views, strict=True)]
    )
    return Level(size, centres, np.asarray(wrapped(yaws)), sure, prior)


def _class(start: Start, priors: Sequence[SizePrior]) -> SizePrior:
    """Return the class that is the most likely one in most frames."""
    counts = [start.priors.count(prior) for prior in priors]
    return priors[int(np.argmax(counts))]


def _sides(
    view: View, yaw: float, ground: float | None, prior: SizePrior, options: FitOptions
) -> Sides:
    eyes, ends = rays_of([view])
    return find_sides(view.xyz, eyes, ends, yaw, ground, prior, options)


def _directions(
    views: list[View], start: Start, path: Floats, yaws: Floats, times: Floats, prior: SizePrior,
    size: Floats, options: FitOptions,
) -> Floats:  # fmt: skip
    """Return the yaw (k,) in each frame, by the path while it moves, and by outlines."""
    velocity = speeds(path, times)
    speed = np.linalg.norm(velocity, axis=1)
    if not start.moves or (speed < (options.walking if prior.person else SLOW)).all():
        return _by_outlines(views, yaws, times, options)
    along = np.arctan2(velocity[:, 1], velocity[:, 0])
    slow = speed < (options.walking if prior.person else SLOW)
    if slow.any():  # keeps the direction of the nearest frame in which it moves
        moving = np.flatnonzero(~slow)
        along = along[moving[np.abs(np.arange(len(along))[:, None] - moving).argmin(axis=1)]]
    if prior.person:
        return smooth_angles(
            along, np.full(len(along), 0.3), times, np.radians(options.person_swerve)
        )
    turning = np.gradient(np.unwrap(along), times) if len(along) > 1 else np.zeros(len(along))
    slip = np.arctan(np.clip(AXLE * size[0] * turning / np.maximum(speed, SLOW), -0.5, 0.5))
    guess = along - slip
    # A slow or turning path is less reliable.
    far = np.clip(speed * min(options.path_seconds, float(times[-1] - times[0])), 0.1, None)
    path_noise = options.path_noise / far + np.abs(turning) * options.path_lag
    path_noise = np.clip(path_noise, np.radians(1), np.radians(25))
    found, noise = np.empty(len(views)), np.empty(len(views))
    for k, view in enumerate(views):
        part = shell(view.xyz, start.ground[k], options)
        within = max(float(OUTLINE_WITHIN), 1.5 * float(path_noise[k]))
        outline = outline_yaw(part, float(guess[k]), within, options)
        ratio = np.clip(np.sqrt(options.lshape_points / len(part)), 1 / 3, 3)
        weak = np.radians(options.lshape_noise) * ratio
        a, b = 1 / path_noise[k] ** 2, 1 / weak**2
        found[k] = guess[k] + float(wrapped(outline - guess[k], np.pi / 2)) * b / (a + b)
        noise[k] = 1 / np.sqrt(a + b)
    return smooth_angles(found, noise, times, np.radians(options.swerve))


def _by_outlines(views: list[View], yaws: Floats, times: Floats, options: FitOptions) -> Floats:
    """Return yaws by outlines alone, with a consistent forward direction over frames."""
    agreed = yaws.copy()
    for k in range(1, len(agreed)):  # the nearest of the two opposite directions
        agreed[k] = agreed[k - 1] + float(wrapped(yaws[k] - agreed[k - 1], np.pi))
    weight = np.array([len(view.xyz) for view in views], float)
    noise = np.radians(options.lshape_noise) * np.sqrt(weight.max() / weight)
    return smooth_angles(agreed, noise, times, np.radians(options.swerve) * 2)
