"""Kind and place of the sensor of one frame, outside of a run."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pointbrush.sensor_kind import SensorKind
from pointbrush.tracking.interface import F64, PositionsFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.scanner import find_eye, reach_of
from pointbrush.tracking.sensors.view import View


@dataclass(frozen=True, slots=True, eq=False)
class Sensing:
    """``kind`` of a sensor, and its ``place`` (3,) in the frame's coordinates or None."""

    kind: SensorKind
    place: F64 | None


def sense(frame: PositionsFrame, origin: F64, options: TrackerOptions | None = None) -> Sensing:
    """Tell a frame's sensor by what the import knows, else by what its points show.

    Its place is the one that is told, that of the picture which the points fill, the ``origin``
    (3,) of the source in a frame with a pose, or that from where the points hide nothing of each
    other; else it is unknown.
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


def _looks_one_way(frame: PositionsFrame, place: F64, options: TrackerOptions) -> bool:
    """Whether a sensor looks one way from a place, and no farther than depth cameras do: a picture
    that was thinned is filled no more."""
    local = frame.xyz - place
    rays = local / np.maximum(np.linalg.norm(local, axis=1, keepdims=True), 1e-9)
    straight = float(np.linalg.norm(rays.mean(axis=0)))
    near = reach_of(frame.xyz, options=options.range_image) <= options.range_image.camera_reach_m
    return near and straight >= options.viewpoint.min_mean_ray
