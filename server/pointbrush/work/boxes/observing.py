"""Observations of labels in the frames of a recording, for the fit of their boxes."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting import FitOptions, Observation, near_rays
from pointbrush.labels import LabelStore
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import StoredFrame
from pointbrush.work.tracking.sensor import sensor_of

Floats = NDArray[np.float64]
REACH = 5.0
"""Distance around an object within which the frame's other points are used, metres."""


def observed(
    store: LabelStore, recording: Recording, labels: Collection[int], frames: Sequence[int],
    options: FitOptions,
) -> Iterator[tuple[int, dict[int, Observation]]]:  # fmt: skip
    """Yield each frame and its observations by label, source coordinates."""
    manifest = recording.manifest
    up = np.asarray(manifest.T_room_local[1, :3], np.float64)
    place = None
    if all(recording[frame].viewpoint is None for frame in frames[:1]):
        place = sensor_of(recording).place
    view = store.view(manifest.id)
    times = np.array([np.nan if t is None else t for t in manifest.timestamps], np.float64)
    # Equal or decreasing times give no speed; frames are then spaced by the rate.
    if not (np.diff(times) > 0).all() or np.isnan(times).any():
        times = np.arange(manifest.frames) / manifest.fps
    for index in frames:
        frame = recording[index]
        values = view.values(index, 0, None)
        label = np.where(values.deleted, 0, values.label)
        xyz = np.asarray(frame.xyz, np.float64) + manifest.shift
        living = xyz[~values.deleted]
        rays = _of_first_sensor(frame)[~values.deleted]
        kept = label[~values.deleted]
        sensor = _sensor(frame, place, manifest.shift)
        found = {}
        for number in labels:
            own = kept == number
            if own.sum() < options.least_points:
                continue
            others = near_rays(living[own], living[~own & rays], sensor, up, REACH)
            others = others[:: -(-len(others) // options.most_rays) or 1]
            found[number] = Observation(
                index, living[own], up, float(times[index]), sensor, frame.pose, others
            )
        yield index, found


def _of_first_sensor(frame: StoredFrame) -> NDArray[np.bool_]:
    """Return a mask (N,) of the points whose rays start at the viewpoint, of several sensors."""
    if frame.sensor is None or not frame.parts:
        return np.ones(frame.count, np.bool_)
    return np.asarray(frame.sensor == frame.parts[0].sensor)


def _sensor(
    frame: StoredFrame, place: tuple[float, float, float] | None, shift: Sequence[float]
) -> Floats | None:
    """Return the position of the sensor in a frame, source coordinates."""
    where = frame.viewpoint if frame.viewpoint is not None else place
    return None if where is None else np.asarray(where, np.float64) + np.asarray(shift, np.float64)
