"""Properties of a recording's sensor, determined once for all runs.

An unrecorded position of a sensor is estimated from occlusions and the sampling density.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from pointbrush.tracking.interface import F32, F64, Frames, KnownSensor, TrackFrame
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.sensors import ViewpointOptions
from pointbrush.tracking.sensors.camera import Lens, axes_along, find_lens
from pointbrush.tracking.sensors.scan_odometry import recorded_trajectory, shown_at_rest
from pointbrush.tracking.sensors.scanner import reach_of


def most_even_place(xyz: F64, place: F64, size: float, options: ViewpointOptions) -> F64:
    """Return the position (3,) near ``place`` from which points (N, 3) fill an image most evenly.

    ``size``: size of the scene in metres.
    """
    middle = np.median(xyz, axis=0)

    def cost(there: F64) -> float:
        return unevenness(xyz, there, options=options)

    starts = [middle + share * (place - middle) for share in options.distance_shares]
    first, last = (step * size for step in options.direction_steps)
    place = min(starts, key=cost)
    return _descended(cost, place, _ways(middle - place), first, last)


def _descended(
    cost: Callable[[F64], float], place: F64, ways: Iterable[F64], step: float, last: float
) -> F64:
    """Return the position of a minimal cost, by coordinate descent along ``ways`` (3,).

    The step is halved when no direction reduces the cost.
    """
    least, ways = cost(place), list(ways)
    while step > last:
        before = least
        for way in ways:
            there = place + step * way
            new = cost(there)
            if new < least:
                place, least = there, new
        if least == before:
            step /= 2
    return place


def unevenness(xyz: F64, place: F64, options: ViewpointOptions) -> float:
    """Return the mean absolute log ratio of points in parts of the image to their usual number.

    The usual number varies smoothly over an image that does not look along its axis.  inf: no image
    is so wide.
    """
    local = xyz - place
    rays = local / (np.sqrt(np.einsum("ij,ij->i", local, local))[:, None] + 1e-9)
    forward = rays.mean(axis=0)
    straight = float(np.linalg.norm(forward))
    if straight < options.min_mean_ray:
        return np.inf
    to_right, to_bottom, ahead = axes_along(forward / straight)
    depth = np.maximum(rays @ ahead, options.min_ray_cos)
    across, down = rays @ to_right / depth, rays @ to_bottom / depth
    pitch = options.part_spacings * float(np.sqrt(np.ptp(across) * np.ptp(down) / len(xyz))) + 1e-9
    column, row = (((t - t.min()) / pitch).astype(np.int64) for t in (across, down))
    width = int(column.max()) + 1
    count = np.bincount(row * width + column)
    part = np.flatnonzero(count >= options.part_spacings)
    x, y = part % width * pitch, part // width * pitch
    slow = np.stack([np.ones(len(part)), x, y, x * x, x * y, y * y], axis=1)
    many = np.log(count[part])
    usual = slow @ np.linalg.lstsq(slow, many, rcond=None)[0]
    return float(np.abs(many - usual).mean()) if len(part) else np.inf


def _ways(forward: F64) -> F64:
    """Return (14, 3) directions along the axes of an image facing ``forward``, and oblique ones."""
    right, down, ahead = axes_along(forward / max(float(np.linalg.norm(forward)), 1e-9))
    askew = [a + b for a in (right, down, -right, -down) for b in (ahead, -ahead)]
    return np.array([right, down, ahead, -right, -down, -ahead, *askew])


def find_camera(xyz: F32, options: TrackerOptions) -> F64 | None:
    """Return the position (3,) of a pinhole-like sensor from its points (N, 3); None: none fits.

    The caller has to check that the points fill an image from there.
    """
    viewpoint_options = options.viewpoint
    if len(xyz) < viewpoint_options.min_points:
        return None
    few, many, every = (
        _thinned(xyz, most)
        for most in (viewpoint_options.coarse_points, viewpoint_options.fine_points, len(xyz))
    )
    middle = np.median(few, axis=0)
    size = float(np.median(np.linalg.norm(few - middle, axis=1)))
    if size <= 0:
        return None
    distances = np.array(viewpoint_options.distance_sizes)[:, None, None]
    places = middle + size * (distances * _all_round(options=viewpoint_options)).reshape(-1, 3)
    gap = viewpoint_options.hidden_sizes * size
    costs = np.array([_hidden(few, place, gap, options=options) for place in places])
    if costs.min() > viewpoint_options.hidden_share_far:
        return None
    first, last, least = (step * size for step in viewpoint_options.place_steps)
    likely = places[np.argsort(costs, kind="stable")[: viewpoint_options.followed_places]]
    found = [_closer(many, place, gap, first, last, options=options) for place in likely]
    best = min(found, key=lambda place: _hidden(many, place, gap, options=options))
    if _hidden(many, best, gap, options=options) > 2 * viewpoint_options.hidden_share:
        return None
    place = _closer(every, best, gap, 2 * last, least, options=options)
    if _hidden(every, place, gap, options=options) >= viewpoint_options.hidden_share:
        return None
    closer = most_even_place(many, place, size, options=viewpoint_options)
    nearer = _hidden(every, closer, gap, options=options) < viewpoint_options.hidden_share
    return closer if nearer else place


def _thinned(xyz: F32, most: int) -> F64:
    return np.asarray(xyz[:: max(1, len(xyz) // most)], np.float64)


def _all_round(options: ViewpointOptions) -> F64:
    """Return (DIRECTIONS, 3) uniform unit vectors by a Fibonacci lattice."""
    at = np.arange(options.directions) + 0.5
    down, round_ = np.arccos(1 - 2 * at / options.directions), np.pi * (1 + 5**0.5) * at
    across = np.sin(down)
    return np.stack([across * np.cos(round_), across * np.sin(round_), np.cos(down)], axis=1)


def _closer(
    xyz: F64, place: F64, gap: float, step: float, last: float, options: TrackerOptions
) -> F64:
    """Return a position with fewer hidden points, by coordinate descent with halved steps."""
    ways = (*np.eye(3), *-np.eye(3))
    return _descended(lambda at: _hidden(xyz, at, gap, options), place, ways, step, last)


def _hidden(xyz: F64, place: F64, gap: float, options: TrackerOptions) -> float:
    """Return the share of the points (N, 3) occluded from a position; 1: no image is so wide."""
    local = xyz - place
    distance = np.sqrt(np.einsum("ij,ij->i", local, local)) + 1e-9
    rays = local / distance[:, None]
    forward = rays.mean(axis=0)
    straight = float(np.linalg.norm(forward))
    if straight < options.viewpoint.min_mean_ray:
        return 1.0
    forward /= straight
    ahead = rays @ forward
    if (ahead < options.viewpoint.min_ray_cos).mean() > options.viewpoint.stray_share:
        return 1.0
    to_right, to_bottom, _ = axes_along(forward)
    depth = np.maximum(ahead, options.viewpoint.min_ray_cos)
    across, down = rays @ to_right / depth, rays @ to_bottom / depth
    pitch = (
        options.lens.pixel_spacings * float(np.sqrt(np.ptp(across) * np.ptp(down) / len(xyz)))
        + 1e-9
    )
    column, row = ((t - t.min()) / pitch for t in (across, down))
    cell = row.astype(np.int64) * (int(column.max()) + 1) + column.astype(np.int64)
    nearest = np.full(int(cell.max()) + 1, np.inf)
    np.minimum.at(nearest, cell, distance)
    return float(np.mean(distance > nearest[cell] + gap))


def examine(frames: Frames, count: int, options: TrackerOptions) -> KnownSensor:
    """Return the properties of a recording's sensor by its ``count`` frames.

    A camera with frames in room coordinates is at rest; if unsure, each run checks for itself.
    """
    order = range(count)
    first, *others = (frames(order[at]) for at in (0, count // 2, -1))
    placeless = False
    if _has_no_position(first, options=options) and len(first.xyz) >= options.viewpoint.min_points:
        place = find_camera(np.asarray(first.xyz), options=options)
        if place is not None and _seen_from(place, first, others, options=options) is not None:
            x, y, z = place.tolist()
            return KnownSensor(place=(x, y, z))
        placeless = place is None
    trajectory, _ = recorded_trajectory(frames, order, options=options)
    spread = np.linspace(0, count - 1, min(count, options.scan_odometry.examined_frames + 1))
    numbers = [int(number) for number in spread]
    at_rest = trajectory is None and count > 1 and shown_at_rest(frames, numbers, options=options)
    return KnownSensor(at_rest=at_rest, placeless=placeless)


def lens_at_rest(
    first: TrackFrame, others: Sequence[TrackFrame], known: KnownSensor, options: TrackerOptions
) -> Lens | None:
    """Return the pixel grid of a camera at rest with frames in room coordinates.

    It is estimated if the frame does not have it, and must be valid in the ``others`` as well.
    """
    if known.placeless or not _has_no_position(first, options=options):
        return None
    if known.place is not None:
        lens = _seen_from(np.array(known.place), first, others, options=options)
        if lens is not None:
            return lens
    place = find_camera(np.asarray(first.xyz), options=options)
    return None if place is None else _seen_from(place, first, others, options=options)


def _has_no_position(frame: TrackFrame, options: TrackerOptions) -> bool:
    """Return whether a frame of a depth camera's range has no position, pose or pixel grid."""
    return (
        frame.viewpoint is None
        and frame.sensor is None
        and frame.pose is None
        and reach_of(np.asarray(frame.xyz), options=options.range_image)
        <= options.range_image.camera_reach_m
        and find_lens(frame, options=options) is None
    )


def _seen_from(
    place: F64, first: TrackFrame, others: Sequence[TrackFrame], options: TrackerOptions
) -> Lens | None:
    """Return the pixel grid of ``first`` from a position; None: it does not fit all frames."""
    if any(find_lens(f, place=place, options=options) is None for f in others if len(f.xyz)):
        return None
    return find_lens(first, place=place, options=options)
