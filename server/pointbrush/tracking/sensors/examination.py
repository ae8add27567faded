"""Facts about a recording's sensor that hold for every run over it, found once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pointbrush.tracking.interface import F64, Frames, KnownSensor, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import Lens, find_lens
from pointbrush.tracking.sensors.scan_odometry import shown_at_rest, told_trajectory
from pointbrush.tracking.sensors.scanner import reach_of
from pointbrush.tracking.sensors.viewpoint import find_camera


def examine(frames: Frames, count: int, options: TrackerOptions) -> KnownSensor:
    """Return what the first ``count`` frames, all of a recording, show of its sensor.

    A camera that lies in a room's coordinates is at rest; where nothing is sure, a run looks again.
    """
    order = range(count)
    first, *others = (frames(order[at]) for at in (0, count // 2, -1))
    placeless = False
    if _untold(first, options=options) and len(first.xyz) >= options.viewpoint.min_points:
        place = find_camera(np.asarray(first.xyz), options=options)
        if place is not None and _seen_from(place, first, others, options=options) is not None:
            x, y, z = place.tolist()
            return KnownSensor(place=(x, y, z))
        placeless = place is None
    told, _ = told_trajectory(frames, order, options=options)
    spread = np.linspace(0, count - 1, min(count, options.scan_odometry.examined_frames + 1))
    numbers = [int(number) for number in spread]
    at_rest = told is None and count > 1 and shown_at_rest(frames, numbers, options=options)
    return KnownSensor(at_rest=at_rest, placeless=placeless)


def lens_at_rest(
    first: TrackFrame, others: Sequence[TrackFrame], known: KnownSensor, options: TrackerOptions
) -> Lens | None:
    """The pixel grid of a camera at rest whose frames lie in a room's coordinates.

    It is looked for where no frame tells it; the ``others`` were seen from there as well.
    """
    if known.placeless or not _untold(first, options=options):
        return None
    if known.place is not None:
        lens = _seen_from(np.array(known.place), first, others, options=options)
        if lens is not None:
            return lens
    place = find_camera(np.asarray(first.xyz), options=options)
    return None if place is None else _seen_from(place, first, others, options=options)


def _untold(frame: TrackFrame, options: TrackerOptions) -> bool:
    """Whether a frame of a depth camera's reach tells neither place nor pose nor pixel grid."""
    return (
        frame.viewpoint is None
        and frame.pose is None
        and reach_of(np.asarray(frame.xyz), options=options.range_image)
        <= options.range_image.camera_reach_m
        and find_lens(frame, options=options) is None
    )


def _seen_from(
    place: F64, first: TrackFrame, others: Sequence[TrackFrame], options: TrackerOptions
) -> Lens | None:
    """The pixel grid of the ``first`` frame from a place, None unless all were seen from there."""
    if any(find_lens(f, place=place, options=options) is None for f in others if len(f.xyz)):
        return None
    return find_lens(first, place=place, options=options)
