"""Fit of an object that is static or seen in one frame: one surface, one pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting.observation import Surface, View, surface_of
from pointbrush.fitting.options import FitOptions
from pointbrush.fitting.priors import SizePrior
from pointbrush.fitting.sides import Sides, find_sides, likely_size
from pointbrush.fitting.yaw import outline_yaws, shoulder_yaw, turn

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """A fit in level coordinates.

    ``size`` (3,), ``centres`` (k, 3), ``yaws`` (k,) in radians, ``confidence`` (k,).
    """

    size: Floats
    centres: Floats
    yaws: Floats
    confidence: Floats
    prior: SizePrior


def fit_still(views: Sequence[View], priors: Sequence[SizePrior], options: FitOptions) -> Level:
    """Fit one box to all frames."""
    surface = surface_of(views, options)
    sides, size, prior = best_sides(surface, priors, options)
    centre = world_centre(sides, size, options)
    k = len(views)
    sure = np.full(k, confidence_of(sides, size, len(surface.xyz)))
    return Level(size, np.tile(centre, (k, 1)), np.full(k, sides.yaw), sure, prior)


def best_sides(
    surface: Surface, priors: Sequence[SizePrior], options: FitOptions
) -> tuple[Sides, Floats, SizePrior]:
    """Return sides, size and class for the best yaw and class by the likelihood of sizes."""
    best = None
    outlines = outline_yaws(shell(surface, options), options)
    across = shoulder_yaw(surface.xyz, surface.ground, options)
    for prior in priors:
        yaws = [(yaw + turned, close) for yaw, close in outlines for turned in (0.0, np.pi / 2)]
        if prior.standing and across is not None:
            yaws = [(across, outlines[0][1])]
        for yaw, close in yaws:
            sides = find_sides(surface, yaw, prior, options)
            size, cost = likely_size([sides], prior, options)
            cost -= options.yaw_nats * close
            if best is None or cost < best[0]:
                best = cost, sides, size, prior
    assert best is not None  # noqa: S101 – there is a prior
    return best[1:]


def shell(surface: Surface, options: FitOptions) -> Floats:
    """Return the points for the box's outline: above the ground and below the windows."""
    xyz = surface.xyz
    low = float(xyz[:, 2].min()) if surface.ground is None else surface.ground
    high = float(np.quantile(xyz[:, 2], 0.98))
    part = xyz[
        (xyz[:, 2] > low + options.clearance) & (xyz[:, 2] < low + max(0.65 * (high - low), 0.6))
    ]
    return part if len(part) >= max(10, 0.3 * len(xyz)) else xyz


def world_centre(sides: Sides, size: Floats, options: FitOptions) -> Floats:
    """Return the centre (3,) of a box of a size in level coordinates."""
    middle = sides.middle(size, options.bin_size)
    middle[:2] = turn(sides.yaw) @ middle[:2]
    return np.asarray(middle)


def confidence_of(sides: Sides, size: Floats, points: int) -> float:
    """Return the visible share of a box in plan, 0 to 1; it is lower for few points."""
    seen = np.clip(sides.seen[:2] / size[:2], 0, 1)
    return float((0.3 + 0.7 * seen.prod()) * min(1.0, 0.4 + points / 100))
