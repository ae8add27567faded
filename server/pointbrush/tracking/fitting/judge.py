"""How well a fit explains what the sensor saw, and how far to trust it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.geometry.near import close_to
from pointbrush.tracking.interface import F64, Mask
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.assign import Claim
from pointbrush.tracking.sensor.view import View

FEWEST = 10
"""Model points that must face the sensor for their sides to be a criterion."""

STILL_THERE = 0.25
"""Share of the points that it had in the last frame from which what a lidar sees is there."""


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """``found``: there is something; ``inliers`` share of the visible model that was matched.

    ``hidden`` and ``through`` (M,): model points behind something else, and in front of what
    was measured; ``visible`` share of the facing model that nothing hides.
    """

    found: bool
    inliers: float
    confidence: float
    hidden: Mask
    through: Mask
    visible: float


def judge(
    thing: Thing, view: View, pose: F64 | None, world: F64 | None, found: Claim | None
) -> Verdict:
    """Compare the model at its place with the points assigned to it."""
    n = len(thing.model.xyz)
    nothing = np.zeros(n, np.bool_)
    if pose is None or world is None or found is None:
        return Verdict(False, 0.0, 0.0, nothing, nothing, 0.0)
    facing = thing.model.facing(pose[None], view.eye)[0]
    matched = nothing.copy()
    if len(found.indices):
        reach = 2.5 * thing.unit
        matched[found.nearest[found.gap < reach]] = True
        rest = np.flatnonzero(~matched)
        matched[rest] = close_to(world[rest], view.xyz[found.indices], reach)
    hidden = through = nothing
    if view.lens is not None:
        cell, depth = view.project(world)
        seen = view.depth[cell]
        with np.errstate(invalid="ignore"):
            hidden = (seen < depth - 3 * thing.unit) & ~matched
            through = (seen > depth + 4 * thing.unit) & ~matched & facing
        hidden = hidden | (cell < 0)
    elif view.shade is not None:
        hidden = view.shade.hides(world, 3 * thing.unit) & ~matched
    expected = facing & ~hidden
    if expected.sum() < FEWEST:
        expected = ~hidden
    inliers = float(matched[expected].mean()) if expected.any() else 0.0
    visible = float(expected.sum() / max(1, facing.sum()))
    enough = len(found.indices) >= max(4, 0.01 * thing.size)
    # What hides it from a lidar is known too coarsely to tell all that should be seen.
    much = thing.scanned and len(found.indices) > STILL_THERE * thing.last
    good = enough and (inliers > 0.25 or much)
    confidence = float(np.clip(inliers * min(1.0, 0.4 + visible), 0, 1))
    return Verdict(good, inliers, confidence, hidden, through, visible)
