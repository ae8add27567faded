"""How well a fit explains what the sensor saw, and how far to trust it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.geometry.near import close_to
from pointbrush.tracking.interface import F64, Mask
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.segmentation.assign import Claim
from pointbrush.tracking.sensor.view import View


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
    """Compare the model at ``pose`` (4, 4), its points at ``world`` (M, 3), with what it claims.

    Nothing is found where one of them is None.
    """
    options = thing.options.verdict
    n = len(thing.model.xyz)
    nothing = np.zeros(n, np.bool_)
    if pose is None or world is None or found is None:
        return Verdict(False, 0.0, 0.0, nothing, nothing, 0.0)
    facing = thing.model.facing(pose[None], view.eye)[0]
    matched = nothing.copy()
    if len(found.indices):
        reach = options.surface_units * thing.unit
        matched[found.nearest[found.gap < reach]] = True
        rest = np.flatnonzero(~matched)
        matched[rest] = close_to(world[rest], view.xyz[found.indices], reach)
    hidden = through = nothing
    if view.lens is not None:
        hidden = view.hides(world, options.hidden_units * thing.unit) & ~matched
        through = (
            view.sees_through(world, options.seen_through_units * thing.unit) & ~matched & facing
        )
    elif view.shade is not None:
        hidden = view.shade.hides(world, options.hidden_units * thing.unit) & ~matched
    expected = facing & ~hidden
    if expected.sum() < options.min_facing_points:
        expected = ~hidden
    inliers = float(matched[expected].mean()) if expected.any() else 0.0
    visible = float(expected.sum() / max(1, facing.sum()))
    enough = len(found.indices) >= max(options.min_points, options.min_size_share * thing.size)
    # What hides it from a lidar is known too coarsely to tell all that should be seen.
    much = thing.scanned and len(found.indices) > options.remaining_share * thing.last.points
    good = enough and (inliers > options.present_share or much)
    confidence = float(np.clip(inliers * min(1.0, options.min_trust_share + visible), 0, 1))
    return Verdict(good, inliers, confidence, hidden, through, visible)
