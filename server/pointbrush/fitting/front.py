"""Front of a vehicle that does not move, by its shape.

The windscreen of a car, behind its bonnet, is farther from the end of the body than the rear window
is: this gap is measured at both ends, at several heights.  The cab of a lorry is lower than its
load.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.fitting.observation import View

Floats = NDArray[np.float64]
BODY = (0.2, 0.6)
"""Shares of the height between which a vehicle has its full length."""
SLICES = ((0.86, 1.02), (0.74, 0.9), (0.62, 0.78))
"""Shares of the height between which the ends of the cabin are looked for; the last one is used if
the others have too few points."""
LEAST_POINTS = 8
"""Points of a part of a vehicle from which on its ends are measured."""
GAP = 0.8
"""Metres; longer gaps are more likely those before a windscreen than those behind a rear window."""
GAP_SPREAD = 0.12
"""Metres of difference from ``GAP`` that make this likely."""
UNSEEN = 0.4
"""Metres from the end of the points to the end of the box that halve the weight of a gap there."""
SURE_GAP = 4.0
"""Evidence of one gap at most, in units of ``GAP_SPREAD``."""
SURE = 1.0
"""Mean evidence of the slices from which on the front is known."""
CONTRADICTION = 0.5
"""Evidence of one slice for the opposite front that leaves the front unknown."""
STEP = 0.2
"""Metres; a slice with shorter gaps at both ends is below the windows."""
LONGEST_GAP = 1.8
"""Metres; a longer gap is a part of the cabin that was not seen, or a load bed."""
BED = 1.1
"""Metres; a car with such gaps at both ends has a load bed at one of them."""
LARGE_LENGTH = 6.8
"""Metres; a longer vehicle is a lorry or a bus."""
LARGE_HEIGHT = 2.75
"""Metres; a higher vehicle is one, too."""
CAB_LENGTH = 1.0
"""Metres: length of the ends of a lorry that are compared by height."""
CAB_LOWER = 0.25
"""Metres by which its cab is lower than its load."""
LOAD_HEIGHT = 2.6
"""Metres: least height of a load."""
FLAT_HEIGHT = 1.5
"""Metres; a lower end is a flat bed."""
PASSED = 1.0
"""Metres that the sensor must have moved to know the front of an object that stays in place."""
PASSED_POINTS = 60
"""Points that it must have seen of this object in one frame."""


class Front(NamedTuple):
    """``direction``: 1 for the forward axis, -1 for its opposite; ``sure``: the points say so."""

    direction: int
    sure: bool


def front_of(xyz: Floats, size: Floats) -> Front:
    """Find the front of a vehicle by its points (n, 3) in the axes of its box."""
    along, height = xyz[:, 0], xyz[:, 2] / size[2] + 0.5
    body = along[(height > BODY[0]) & (height < BODY[1])]
    if len(body) < LEAST_POINTS:
        return Front(1, False)
    if size[0] > LARGE_LENGTH or size[2] > LARGE_HEIGHT:
        lower = _lower_end(along, xyz[:, 2] + size[2] / 2, _ends(body))
        return Front(-1 if lower < 0 else 1, lower != 0)
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
    """Compare the gaps between the ends of the body and of the cabin: above 0 for a front ahead;
    None for a slice that shows no cabin."""
    behind, ahead = cabin[0] - body[0], body[1] - cabin[1]
    if max(behind, ahead) < STEP or min(behind, ahead) > BED:
        return None
    return _windscreen(ahead, half - body[1]) - _windscreen(behind, half + body[0])


def _windscreen(gap: float, unseen: float) -> float:
    """Compute the evidence that a gap is that of a windscreen; ``unseen`` metres of the box are
    beyond the points."""
    if gap > LONGEST_GAP:
        return 0.0
    beyond = max(unseen, 0.0)
    evidence = np.clip((gap + beyond / 2 - GAP) / GAP_SPREAD, -SURE_GAP, SURE_GAP)
    return float(evidence / (1 + (beyond / UNSEEN) ** 2))


def _lower_end(along: Floats, height: Floats, body: tuple[float, float]) -> int:
    """Find the cab of a lorry by its height: 1 for a cab ahead, -1 for one behind, 0: unknown."""
    ends = height[along < body[0] + CAB_LENGTH], height[along > body[1] - CAB_LENGTH]
    if min(map(len, ends)) < LEAST_POINTS:
        return 0
    behind, ahead = (float(np.quantile(each, 0.98)) for each in ends)
    if max(behind, ahead) < LOAD_HEIGHT or abs(ahead - behind) < CAB_LOWER:
        return 0
    lower = 1 if ahead < behind else -1
    return lower if min(behind, ahead) > FLAT_HEIGHT else -lower


def _ends(along: Floats) -> tuple[float, float]:
    """Compute both ends of points, without the two outermost of many."""
    ordered = np.sort(along)
    skipped = min(2, (len(ordered) - 1) // 8)
    return float(ordered[skipped]), float(ordered[-1 - skipped])


def passed(views: list[View]) -> bool:
    """Tell whether a sensor passed an object near enough to know its front; ``views`` are posed."""
    places = np.array([view.T_level_frame[:3, 3] for view in views])
    moved = float(np.linalg.norm(places - places[0], axis=1).max())
    return moved > PASSED and max(len(view.xyz) for view in views) >= PASSED_POINTS
