"""Joining of the frames of several sensors by their times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import Sensor

Seconds = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class JoinedSensor:
    """A sensor of a recording: ``joined`` of its frames are in it, and ``left_out`` are not.

    ``apart``: median time between its frames and the reference sensor's, seconds, or None if they
    are joined in their order.
    """

    sensor: Sensor
    joined: int
    left_out: int
    apart: float | None = None


def joined_frames(reference: Sequence[float], times: Sequence[float]) -> list[int | None]:
    """Return the frame of another sensor that joins each frame of the reference sensor, or None.

    Both have increasing times, seconds.  A frame joins the nearest frame of the reference within
    half the period of the reference, the median step of its times.  Of several such frames the
    nearest joins, the first if they are equally near; so no frame joins twice.
    """
    found: list[int | None] = [None] * len(reference)
    if not len(reference) or not len(times):
        return found
    at, other = np.asarray(reference, np.float64), np.asarray(times, np.float64)
    limit = half_period(at, other)
    nearest = nearest_of(at, other)
    apart = np.abs(other - at[nearest])
    for frame in np.lexsort((np.arange(len(other)), apart)).tolist():
        place = int(nearest[frame])
        if apart[frame] <= limit and found[place] is None:
            found[place] = frame
    return found


def half_period(reference: Seconds, times: Seconds) -> float:
    """Return half the median step of the reference, or of the other times for a single frame."""
    for known in (reference, times):
        steps = np.diff(known)
        if (steps > 0).any():
            return float(np.median(steps[steps > 0])) / 2
    return float("inf")


def nearest_of(reference: Seconds, times: Seconds) -> NDArray[np.int64]:
    """Return the place of the reference time that is nearest to each time, the earlier of two."""
    after = np.searchsorted(reference, times).clip(1, max(len(reference) - 1, 1))
    sides = np.minimum(np.stack([after - 1, after]), len(reference) - 1)
    second = np.abs(reference[sides[1]] - times) < np.abs(reference[sides[0]] - times)
    return np.asarray(np.where(second, sides[1], sides[0]), np.int64)
