"""Fit of a moving object: sides frame by frame, a smooth path through them, and yaws along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting.observation import Surface, View, surface_of
from pointbrush.fitting.options import FitOptions
from pointbrush.fitting.parked import (
    Level,
    best_sides,
    confidence_of,
    shell,
    world_centre,
)
from pointbrush.fitting.priors import SizePrior
from pointbrush.fitting.sides import find_sides, likely_size
from pointbrush.fitting.trajectory import smooth_angles, smooth_path, speeds
from pointbrush.fitting.yaw import outline_yaw, wrapped

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Estimate of an object with a common ``size`` (3,) and class ``prior``.

    ``surfaces`` of each frame; path (k, 2) of the centres, in metres, and ``yaws`` (k,) in radians
    at ``times`` (k,) in seconds; whether the object ``moves``.
    """

    surfaces: list[Surface]
    path: Floats
    yaws: Floats
    times: Floats
    size: Floats
    prior: SizePrior
    moves: bool


def start_of(
    views: list[View], posed: bool, priors: Sequence[SizePrior], options: FitOptions
) -> Motion:
    """Fit each frame separately, and decide whether the object moves."""
    surfaces = [surface_of([view], options) for view in views]
    found = [best_sides(surface, priors, options) for surface in surfaces]
    chosen = [prior for _, _, prior in found]
    size = np.median([each for _, each, _ in found], axis=0)
    if len(found) >= options.agreeing:
        found = [
            best_sides(surface, [_of_size(prior, size, options)], options)
            for surface, prior in zip(surfaces, chosen, strict=True)
        ]
    places = np.array([world_centre(sides, each, options)[:2] for sides, each, _ in found])
    times = np.array([view.time for view in views])
    noise = np.full((len(views), 2), options.start_noise)
    yaws = np.array([sides.yaw for sides, _, _ in found])
    path = smooth_path(places, noise, yaws, times, options.acceleration)
    moves = posed and _moves(views, path, options)
    prior = max(priors, key=chosen.count)
    return Motion(surfaces, path, yaws, times, size, prior, moves)


def _of_size(prior: SizePrior, size: Floats, options: FitOptions) -> SizePrior:
    """Return a prior of the common size (3,) of several frames."""
    a, b, c = (options.agreed_spread * each for each in prior.spread)
    return replace(prior, mean=(size[0], size[1], size[2]), spread=(a, b, c))


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


def fit_moving(motion: Motion, options: FitOptions) -> Level:
    """Fit a common size and a pose for each frame."""
    prior = motion.prior
    for _ in range(options.rounds):
        yaws = _directions(motion, options)
        sides = [
            find_sides(surface, float(yaw), prior, options)
            for surface, yaw in zip(motion.surfaces, yaws, strict=True)
        ]
        size, _ = likely_size(sides, prior, options)
        places = np.array([world_centre(each, size, options)[:2] for each in sides])
        slack = np.array([each.slack(size)[:2] for each in sides])
        noise = options.side_noise + slack / 2
        path = smooth_path(places, noise, yaws, motion.times, options.acceleration)
        motion = replace(motion, path=path, yaws=yaws, size=size)
    heights = np.array([each.low[2] for each in sides]) + size[2] / 2
    counts = [len(surface.xyz) for surface in motion.surfaces]
    sure = [confidence_of(each, size, n) for each, n in zip(sides, counts, strict=True)]
    centres = np.column_stack([motion.path, heights])
    return Level(size, centres, np.asarray(wrapped(motion.yaws)), np.array(sure), prior)


def _directions(motion: Motion, options: FitOptions) -> Floats:
    """Return the yaw (k,) in each frame, by the path while it moves, and by outlines."""
    times, prior = motion.times, motion.prior
    velocity = speeds(motion.path, times)
    speed = np.linalg.norm(velocity, axis=1)
    slow = speed < (options.walking if prior.person else options.driving)
    if not motion.moves or slow.all():
        return _by_outlines(motion, options)
    along = np.arctan2(velocity[:, 1], velocity[:, 0])
    if slow.any():  # keeps the direction of the nearest frame in which it moves
        moving = np.flatnonzero(~slow)
        along = along[moving[np.abs(np.arange(len(along))[:, None] - moving).argmin(axis=1)]]
    if prior.person:
        noise = np.full(len(along), np.radians(options.person_noise))
        return smooth_angles(along, noise, times, np.radians(options.person_swerve))
    turning = np.gradient(np.unwrap(along), times) if len(along) > 1 else np.zeros(len(along))
    steer = options.axle * motion.size[0] * turning / np.maximum(speed, options.driving)
    guess = along - np.arctan(np.clip(steer, -options.steer_most, options.steer_most))
    # A slow or turning path is less reliable.
    far = np.clip(speed * min(options.path_seconds, float(times[-1] - times[0])), 0.1, None)
    path_noise = options.path_noise / far + np.abs(turning) * options.path_lag
    path_noise = np.clip(path_noise, *np.radians(options.path_angles))
    found, noise = np.empty(len(along)), np.empty(len(along))
    for k, surface in enumerate(motion.surfaces):
        found[k], noise[k] = _between(surface, float(guess[k]), float(path_noise[k]), options)
    return smooth_angles(found, noise, times, np.radians(options.swerve))


def _between(
    surface: Surface, guess: float, path_noise: float, options: FitOptions
) -> tuple[float, float]:
    """Return a yaw between the path's and the outline's, and its standard deviation, in radians."""
    part = shell(surface, options)
    within = max(float(np.radians(options.outline_within)), 1.5 * path_noise)
    outline = outline_yaw(part, guess, within, options)
    ratio = np.clip(np.sqrt(options.lshape_points / len(part)), 1 / 3, 3)
    weak = np.radians(options.lshape_noise) * ratio
    a, b = 1 / path_noise**2, 1 / weak**2
    yaw = guess + float(wrapped(outline - guess, np.pi / 2)) * b / (a + b)
    return yaw, float(1 / np.sqrt(a + b))


def _by_outlines(motion: Motion, options: FitOptions) -> Floats:
    """Return yaws by outlines alone, with a consistent forward direction over frames."""
    agreed = motion.yaws.copy()
    for k in range(1, len(agreed)):  # the nearest of the two opposite directions
        agreed[k] = agreed[k - 1] + float(wrapped(motion.yaws[k] - agreed[k - 1], np.pi))
    weight = np.array([len(surface.xyz) for surface in motion.surfaces], float)
    noise = np.radians(options.lshape_noise) * np.sqrt(weight.max() / weight)
    return smooth_angles(agreed, noise, motion.times, np.radians(options.swerve) * 2)
