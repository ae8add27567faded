"""How well a pose explains what the sensor saw: model points matched, hidden and seen through."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.registration import Target, transform
from pointbrush.tracking.thing import Thing
from pointbrush.tracking.view import View

NEUTRAL, LEAN = 0.6, 0.1
"""What a pose costs that shows nothing of the model, and the weight of that, in models."""


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Sample points of the model at a pose.

    ``world`` (M, 3); ``seen`` those that face the sensor with nothing before them; ``through``
    those where the sensor saw something behind them; ``facing`` share that faces the sensor.
    """

    world: F64
    seen: Mask
    through: Mask
    facing: float


def look(thing: Thing, view: View, sample: I64, pose: F64) -> Look:
    """Project ``sample`` (M,) model points at ``pose`` into the frame."""
    world = transform(pose, thing.model.xyz[sample])
    facing = thing.model.facing(pose, view.eye, sample)
    seen, through = facing, np.zeros(len(sample), np.bool_)
    if view.lens is not None:
        cell, depth = view.project(world)
        measured = view.depth[cell]
        with np.errstate(invalid="ignore"):
            seen = facing & ~(measured < depth - 4 * thing.unit) & (cell >= 0)
            through = measured > depth + 4 * thing.unit
    return Look(world, seen, through, float(facing.mean()))


def cost_of(
    thing: Thing, view: View, target: Target, sample: I64, pose: F64, scale: float
) -> float:
    """0..1: mean squared distance, in place and colour, of what should be seen; a side that was
    never seen must at least not stand before what was measured."""
    at = look(thing, view, sample, pose)
    wrong = at.through & ~at.seen
    total = float(np.count_nonzero(wrong))
    count = total + float(np.count_nonzero(at.seen))
    if at.seen.any():
        colour = thing.model.colour[sample[at.seen]]
        distance, _ = target.nearest(at.world[at.seen], colour, 3.0 * scale)
        total += float(((distance / (3.0 * scale)) ** 2).sum())
    lean = LEAN * len(sample)
    return (total + lean * NEUTRAL) / (count + lean)
