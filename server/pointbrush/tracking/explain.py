"""How well poses explain what the sensor saw: model points matched, hidden and seen through."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.registration import Target, transform_each
from pointbrush.tracking.thing import Thing
from pointbrush.tracking.view import View

NEUTRAL, LEAN = 0.6, 0.1
"""What a pose costs that shows nothing of the model, and the weight of that, in models."""


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Sample points (M,) of the model at each of K poses.

    ``world`` (K, M, 3); ``seen`` (K, M) those that face the sensor with nothing before them;
    ``through`` (K, M) those where the sensor saw something behind them; ``facing`` (K,) share that
    faces the sensor.
    """

    world: F64
    seen: Mask
    through: Mask
    facing: F64


def look(thing: Thing, view: View, sample: I64, poses: F64) -> Look:
    """Project ``sample`` (M,) model points at ``poses`` (K, 4, 4) into the frame."""
    world = transform_each(poses, thing.model.xyz[sample])
    facing = thing.model.facing(poses, view.eye, sample)
    seen, through = facing, np.zeros(facing.shape, np.bool_)
    if view.lens is not None:
        cell, depth = (each.reshape(facing.shape) for each in view.project(world.reshape(-1, 3)))
        measured = view.depth[cell]
        with np.errstate(invalid="ignore"):
            seen = facing & ~(measured < depth - 4 * thing.unit) & (cell >= 0)
            through = measured > depth + 4 * thing.unit
    elif view.shade is not None:
        hidden = view.shade.hides(world.reshape(-1, 3), 4 * thing.unit)
        seen = facing & ~hidden.reshape(facing.shape)
    share = np.array([np.count_nonzero(row) for row in facing]) / max(len(sample), 1)
    return Look(world, seen, through, share)


def costs_of(thing: Thing, target: Target, sample: I64, at: Look, scale: float) -> F64:
    """(K,) 0..1: mean squared distance, in place and colour, of what should be seen at each pose.

    A side that was never seen must at least not stand before what was measured.
    """
    pose, point = np.nonzero(at.seen)
    before, _ = np.nonzero(at.through & ~at.seen)
    total = np.bincount(before, minlength=len(at.seen)).astype(np.float64)
    count = total + np.bincount(pose, minlength=len(total))
    if len(pose):
        colour = thing.model.colour[sample[point]]
        distance, _ = target.nearest(at.world[pose, point], colour, 3.0 * scale)
        square = (distance / (3.0 * scale)) ** 2
        total += np.bincount(pose, weights=square, minlength=len(total))
    lean = LEAN * len(sample)
    return np.asarray((total + lean * NEUTRAL) / (count + lean))
