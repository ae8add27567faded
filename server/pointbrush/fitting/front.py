"""Front of a static vehicle, by its shape.

The windscreen of a car is farther from the end of the body than the rear window.  This gap is
measured at both ends and several heights.  The cab of a lorry is lower than its load, or there is
a gap between them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting.observation import View

Floats = NDArray[np.float64]
BODY = (0.2, 0.6)
"""Range of shares of the height in which a vehicle has its full length."""
SLICES = ((0.86, 1.02), (0.74, 0.9), (0.62, 0.78))
"""Ranges of shares of the height for the ends of the cabin; the last one is used if the others have
too few points."""
LEAST_POINTS = 8
"""Minimum number of points of a part of a vehicle to measure its ends."""
GAP = 0.8
"""Metres; longer gaps are more likely at a windscreen than at a rear window."""
GAP_SPREAD = 0.12
"""Metres of difference from ``GAP`` that make this likely."""
UNSEEN = 0.4
"""Metres from the end of the points to the end of the box that halve the weight of a gap there."""
SURE_GAP = 4.0
"""Maximum evidence of one gap, in units of ``GAP_SPREAD``."""
SURE = 1.0
"""Mean evidence of the slices from which the front is known."""
CONTRADICTION = 0.5
"""Evidence of one slice for the opposite front that leaves the front unknown."""
STEP = 0.2
"""Metres; a slice with shorter gaps at both ends is below the windows."""
LONGEST_GAP = 1.8
"""Metres; a longer gap is an unseen part of the cabin, or a load bed."""
BED = 1.1
"""Metres; a car with such gaps at both ends has a load bed at one of them."""
LARGE_LENGTH = 6.8
"""Metres; a longer vehicle is a lorry or a bus."""
LARGE_HEIGHT = 2.75
"""Metres; a higher vehicle is a lorry or a bus."""
CAB_LENGTH = 1.0
"""Metres: length of the ends of a lorry that are compared by height."""
CAB_LOWER = 0.25
"""Metres by which its cab is lower than its load."""
LOAD_HEIGHT = 2.6
"""Metres: least height of a load."""
FLAT_HEIGHT = 1.5
"""Metres; a lower end is a flat bed."""
SIDE = (0.4, 0.75)
"""Range of shares of the height in which the sides of a cab and of a load are closed."""
CAB_GAP = 0.1
"""Metres: minimum gap between a cab and its load …"""
CAB_GAP_RATIO = 2.0
"""… and its minimum ratio to the next gap: the windows of a bus are several gaps."""
CAB_DISTANCE = (1.0, 3.2)
"""Range of distances of this gap from the front, in metres."""
PASSED = 1.0
"""Minimum motion of the sensor, in metres, to know the front of a static object."""
PASSED_POINTS = 60
"""Minimum number of the object's points in one of the frames."""


class Front(NamedTuple):
    """``direction``: 1 for the forward axis, -1 for its opposite; ``sure``: it is certain."""

    direction: int
    sure: bool


def front_of(xyz: Floats, size: Floats) -> Front:
    """Return the front of a vehicle by its points (n, 3) in the axes of its box."""
    along, height = xyz[:, 0], xyz[:, 2] / size[2] + 0.5
    body = along[(height > BODY[0]) & (height < BODY[1])]
    if len(body) < LEAST_POINTS:
        return Front(1, False)
    if size[0] > LARGE_LENGTH or size[2] > LARGE_HEIGHT:
        cab = _lower_end(along, xyz[:, 2] + size[2] / 2, _ends(body))
        cab = cab or _gap_end(along[(height > SIDE[0]) & (height < SIDE[1])], _ends(body))
        return Front(-1 if cab < 0 else 1, cab != 0)
    found: list[float] = []
    for number, (low, high) in enumerate(SLICES):
        cabin = along[(height > low) & (height <= high)]
        if len(cabin) < LEAST_POINTS or (number == len(SLICES) - 1 and found):
            continue
        evidence = _slice_evidence(_ends(body), _ends(cabin), float(size[0]) / 2)
        if evidence is not None:
            found.append(evidence / (1 + 1 / np.sqrt(min(len(cabin), len(body)))))
    mean = float(np.mean(found)) if found else 0.0
    direction = -1 if mean < 0 else 1
    against = max((-each * direction for each in found), default=0.0)
    return Front(direction, abs(mean) > SURE and against < CONTRADICTION)


def _slice_evidence(
    body: tuple[float, float], cabin: tuple[float, float], half: float
) -> float | None:
    """Return evidence of a front ahead, above 0, by the gaps between the ends of body and cabin.

    None: the slice has no cabin.
    """
    behind, ahead = cabin[0] - body[0], body[1] - cabin[1]
    if max(behind, ahead) < STEP or min(behind, ahead) > BED:
        return None
    return _windscreen(ahead, half - body[1]) - _windscreen(behind, half + body[0])


def _windscreen(gap: float, unseen: float) -> float:
    """Return the evidence that a gap is at a windscreen.

    ``unseen``: metres of the box beyond the points.
    """
    if gap > LONGEST_GAP:
        return 0.0
    beyond = max(unseen, 0.0)
    evidence = np.clip((gap + beyond / 2 - GAP) / GAP_SPREAD, -SURE_GAP, SURE_GAP)
    return float(evidence / (1 + (beyond / UNSEEN) ** 2))


def _lower_end(along: Floats, height: Floats, body: tuple[float, float]) -> int:
    """Return the end of a lorry with the cab, by height: 1 ahead, -1 behind, 0 unknown."""
    ends = height[along < body[0] + CAB_LENGTH], height[along > body[1] - CAB_LENGTH]
    if min(map(len, ends)) < LEAST_POINTS:
        return 0
    behind, ahead = (float(np.quantile(each, 0.98)) for each in ends)
    if max(behind, ahead) < LOAD_HEIGHT or abs(ahead - behind) < CAB_LOWER:
        return 0
    lower = 1 if ahead < behind else -1
    return lower if min(behind, ahead) > FLAT_HEIGHT else -lower


def _gap_end(side: Floats, body: tuple[float, float]) -> int:
    """Return the end of a lorry with the cab, by the gap behind it: 1 ahead, -1 behind, 0 unknown.

    ``side`` (n,): positions of points of the sides along the lorry.
    """
    if len(side) < LEAST_POINTS:
        return 0
    ordered = np.sort(side)
    gaps = np.diff(ordered)
    second, k = np.sort(gaps)[-2], int(gaps.argmax())
    if gaps[k] < max(CAB_GAP, CAB_GAP_RATIO * float(second)):
        return 0
    behind, ahead = float(ordered[k]) - body[0], body[1] - float(ordered[k + 1])
    if not CAB_DISTANCE[0] < min(behind, ahead) < CAB_DISTANCE[1] < max(behind, ahead):
        return 0
    return 1 if ahead < behind else -1


def _ends(along: Floats) -> tuple[float, float]:
    """Return both ends of points; the two outermost of many points are ignored."""
    ordered = np.sort(along)
    skipped = min(2, (len(ordered) - 1) // 8)
    return float(ordered[skipped]), float(ordered[-1 - skipped])


def passed(views: list[View]) -> bool:
    """Return whether a sensor passed an object so near that its front is known.

    ``views`` have poses.
    """
    places = np.array([view.T_level_frame[:3, 3] for view in views])
    moved = float(np.linalg.norm(places - places[0], axis=1).max())
    return moved > PASSED and max(len(view.xyz) for view in views) >= PASSED_POINTS
