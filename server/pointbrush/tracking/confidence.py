"""How far to trust a fit: the probability of a good label, learnt on generated recordings.

A logistic regression on what a fit says about itself, on table-top, juggling, walking and lidar
recordings: whether IoU is above 0.8.  The scale is then stretched so that above 0.9 nearly all
are good, and nearly all that went wrong are under 0.5.  Source: docs/tracking.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

WEIGHTS = np.array([2.64, 1.44, -2.7, -2.51, -2.55, -1.07, 0.21, -2.12, 1.79, -0.51])
OFFSET = 3.82
STRETCH, MIDDLE = 1.5, 1.1
"""The log odds ``MIDDLE`` are confidence 0.5; they are stretched about it."""
BODY_WEIGHTS = np.array([1.38, 0, -3.28, -0.75, 0, -1.73, -1.0, 0, 0, 3.03, 1.76])
BODY_OFFSET, BODY_MIDDLE = 4.99, 1.5
"""The same for large things before a known scene, people above all: fitted, with each sign held,
on walking people at 30 and at 5 frames a second, with and without what keeps them apart; sudden
changes of size were too rare to fit, and their weight is set."""
ROAM_WEIGHTS = np.array([0, 0, -1.5, 0, 0, 0, -0.91, -0.79, 0.97, 1.98])
ROAM_OFFSET, ROAM_MIDDLE, ROAM_STRETCH = 0.94, 1.0, 1.9
"""The same where a lidar moves: fitted, with each sign held, on generated streets of 16 to 64
beams and the lidar scenes; how much of what moves around is the thing's says the most."""
MANY, FEW = 300, 1.0
"""Points from which a fit before a pixel grid is told apart well, and the weight of the logarithm
of the share of them that there are: small things are taken for each other."""
SHRUNK = 2.0
"""Weight of a changed size of what bends: its model follows whatever is taken for it."""
REGAIN = 0.15
"""Trust that a frame can give back: what has been in doubt may have become another's."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a fit says about itself.

    ``inliers`` share of the visible model matched; ``sure`` share of points on well confirmed
    surface; ``gap`` and ``cost`` mean distances to the model in place, and in place and colour,
    in reaches; ``fit`` cost of the registration; ``size`` and ``change`` number of points over
    the most and over the last; ``grown`` share of points that the model does not explain;
    ``whole`` whether the thing moves alone; ``share`` of the moving points around;
    ``worn`` how much less like what it wore a large thing looks, a mean logarithm, 0 or less;
    ``points`` their number; ``pixels`` whether the sensor has a pixel grid; ``roams`` whether one
    without moves; ``soft`` whether the thing bends.
    """

    inliers: float
    sure: float
    gap: float
    cost: float
    fit: float
    size: float
    change: float
    grown: float
    whole: bool
    share: float
    worn: float
    points: int = MANY
    pixels: bool = True
    roams: bool = False
    soft: bool = False


def likelihood(evidence: Evidence, body: bool = False) -> float:
    """0..1, of this frame by itself; ``body``: of a large thing before a known scene."""
    features = np.array(
        [
            evidence.inliers,
            evidence.sure,
            evidence.gap,
            evidence.cost,
            min(evidence.fit, 1.0),
            abs(_log(evidence.size, 2.0)),
            abs(_log(evidence.change, 1.0)),
            evidence.grown,
            float(evidence.whole),
            evidence.share,
            max(evidence.worn, -3.0),
        ]
    )
    stretch = STRETCH
    if body:
        odds = float(BODY_WEIGHTS @ features) + BODY_OFFSET - BODY_MIDDLE
    elif evidence.roams:
        odds = float(ROAM_WEIGHTS @ features[:-1]) + ROAM_OFFSET - ROAM_MIDDLE
        stretch = ROAM_STRETCH
    else:
        odds = float(WEIGHTS @ features[:-1]) + OFFSET - MIDDLE
        odds -= SHRUNK * features[5] if evidence.soft else 0.0
        odds += FEW * min(0.0, _log(evidence.points / MANY, 7.0)) if evidence.pixels else 0.0
    return 1.0 / (1.0 + float(np.exp(np.clip(-stretch * odds, -30, 30))))


def _log(ratio: float, most: float) -> float:
    return float(np.clip(np.log(max(ratio, 1e-3)), -most, most))
