"""Labels that begin with a person's points, or are learnt anew from other points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pointbrush.tracking.geometry.registration import inverse, transform
from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.objects.thing import Rivals, Thing, begin
from pointbrush.tracking.segmentation.flying_pixels import painted_with_flying
from pointbrush.tracking.segmentation.ground_below import painted_with_ground
from pointbrush.tracking.segmentation.rivals import set_rivals_around, tell_apart
from pointbrush.tracking.sensor.view import View


def begin_label(
    things: dict[int, Thing], view: View, label: int, points: I64, noise: float
) -> None:
    """Put what the ``points`` (M,) of a frame show among the things, its model in the world.

    ``noise`` metres of the depth there.
    """
    thing = begin(view, label, points, noise, Rivals.none())
    thing.painted = replace(
        thing.painted,
        grounded=painted_with_ground(view, points),
        with_flying=painted_with_flying(view, points, thing.unit),
    )
    things[label] = thing
    set_rivals_around(thing, view, thing.model.xyz)


def begin_anew(things: dict[int, Thing], view: View, label: int, points: I64, noise: float) -> F64:
    """Learn a thing from ``points`` (M,) alone; its pose (4, 4), which goes on where it was."""
    before = things[label]
    pose = before.motion.poses[-1]
    shift = np.eye(4)
    if len(points):
        old = transform(pose, before.model.centre[None])[0]
        shift[:3, 3] = view.xyz[points].mean(axis=0) - old
    pose = shift @ pose
    begin_label(things, view, label, points, noise)
    tell_apart(things, view, [label])
    thing = things[label]
    thing.model.xyz = transform(inverse(pose), thing.model.xyz)
    thing.motion.centre, thing.motion.poses = thing.model.centre, [pose]
    return pose
