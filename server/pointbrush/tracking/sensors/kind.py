"""Kind and position of the sensor of a frame, outside of a run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pointbrush.sensor_kind import SensorKind
from pointbrush.tracking.interface import F64, ArrayFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.scanner import find_eye, reach_of
from pointbrush.tracking.sensors.view import View


@dataclass(frozen=True, slots=True, eq=False)
class Sensing:
    """``kind`` of a sensor, and its position ``place`` (3,) in the frame's coordinates or None."""

    kind: SensorKind
    place: F64 | None


def sense(frame: ArrayFrame, origin: F64, options: TrackerOptions | None = None) -> Sensing:
    """Return a frame's sensor by properties of the import, else by its points.

    Its position is the recorded one, the eye of a pixel grid filled by the points, the ``origin``
    (3,) of the source in a frame with a pose, or a position from which no points occlude others;
    otherwise it is unknown.
    """
    options = options or TrackerOptions()
    if not len(frame.xyz):
        return Sensing("room", frame.viewpoint)
    lens = find_lens(frame, moves=frame.pose is not None, options=options)
    few = replace(frame, xyz=frame.xyz[:: -(-len(frame.xyz) // options.lens.sampled_points)])
    place = frame.viewpoint
    if place is None and lens is not None:
        place = lens.eye.astype(np.float64)
    if place is None and frame.pose is not None:
        place = origin
    if place is None:
        place = find_eye(few.xyz, options=options)
    kind = View(0, few, lens, options, frame.pose, place).kind
    if kind == "lidar" and place is not None and _looks_one_way(few, place, options=options):
        kind = "camera"
    return Sensing(kind, place)


def _looks_one_way(frame: ArrayFrame, place: F64, options: TrackerOptions) -> bool:
    """Return whether a sensor looks in one direction, within the range of depth cameras.

    This applies to subsampled frames as well, which do not fill an image.
    """
    local = frame.xyz - place
    rays = local / np.maximum(np.linalg.norm(local, axis=1, keepdims=True), 1e-9)
    straight = float(np.linalg.norm(rays.mean(axis=0)))
    near = reach_of(frame.xyz, options=options.range_image) <= options.range_image.camera_reach_m
    return near and straight >= options.viewpoint.min_mean_ray
