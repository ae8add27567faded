"""How far to trust a fit: the probability of a good label, learnt on generated recordings.

A logistic regression on what a fit says about itself, on table-top, juggling, walking and lidar
recordings: whether IoU is above 0.8.  The scale is then stretched so that above 0.9 nearly all
are good, and nearly all that went wrong are under 0.5.  Source: docs/tracking.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

WEIGHTS, OFFSET = np.array([2.64, 2.5, -3.5, -1.5, -1.0, -1.07, 0.21, -4.0, 1.79, -0.51]), 3.22
"""Of the log odds: a weight for each feature, in the order of ``likelihood``, and what is added."""
STRETCH, MIDDLE = 1.5, 1.1
"""The log odds ``MIDDLE`` are confidence 0.5; they are stretched about it."""
BODY_WEIGHTS = np.array([1.38, 0, -3.28, -0.75, 0, -1.73, -1.0, 0, 0, 3.03, 1.76])
BODY_OFFSET, BODY_MIDDLE = 4.99, 1.5
"""The same for large things before a known scene, people above all: fitted, with each sign held,
on walking people at 30 and at 5 frames a second, with and without what keeps them apart; sudden
changes of size were too rare to fit, and their weight is set."""
SCAN_WEIGHTS = np.array([-0.9, -0.3, -1.53, -5.38, -0.65, -0.63, -4.17])
SCAN_OFFSET, SCAN_MIDDLE, SCAN_STRETCH = -2.7, 0.35, 2.0
"""The same for lidars: what of what moves beside a thing is nobody's, what is another's, its
height, how much it bends, how coarse it is seen, a sudden change of size, and what its model does
not explain.  Fitted on generated streets of 16 to 128 beams, at rest and on the move; what is left
beside a thing says the most, and then whether it is as tall as it was, since whoever stands close
to others leaves nothing beside him but them."""
MANY, FEW = 300, 2.5
"""Points from which a fit before a pixel grid is told apart well, and the weight of the logarithm
of the share of them that there are: small things are taken for each other."""
POINTLIKE = 1.0
"""Units over radius from which a thing is one place, that anything may be at."""
SHRUNK = 3.5
"""Weight of a changed size of what bends: its model follows whatever is taken for it."""
BORDER = 13.0
"""Weight of the border of what has no colours: what holds it touches little of it, and where it is
cut through its own surface, or the hand that it took in through an arm, much of it touches."""
USUAL = 1.2
"""Usual cost in place and colour from which a thing's is taken as a multiple of it: one whose
colours hardly vary beside each other shows all shading as a difference."""
SIZE_MOST, CHANGE_MOST, LEFT_MOST, COARSE_MOST, POINTS_MOST = 2.0, 1.0, 4.0, 6.0, 7.0
"""Logarithms at most of the size and height, of a sudden change of size, of what is left beside a
thing over its own, of how coarse it is, and of how few points it has: beyond, they say no more."""
RATIO_LEAST, ODDS_MOST = 1e-3, 30.0
"""Ratio of which the logarithm is taken at least, and log odds at most: beyond, nothing changes."""
WORN_LEAST = -3.0
"""Mean logarithm under which clothes are another's, however much."""
REGAIN, REGAIN_SCANNED = 0.15, 0.03
"""Trust that a frame can give back: what has been in doubt may have become another's, and what a
lidar shows of the two hardly differs."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a fit says about itself.

    ``inliers`` share of the visible model matched; ``sure`` share of points on well confirmed
    surface; ``gap`` and ``cost`` mean distances to the model in place, and in place and colour,
    in reaches; ``fit`` cost of the registration; ``size`` and ``change`` number of points over
    the most and over the last; ``grown`` share of points that the model does not explain;
    ``whole`` whether the thing moves alone; ``share`` of the moving points around;
    ``worn`` how much less like what it wore a large thing looks, a mean logarithm, 0 or less;
    ``usual`` what ``cost`` mostly was where the thing was alone in the air;
    ``points`` their number; ``pixels`` whether the sensor has a pixel grid; ``scans`` whether it is
    a lidar; ``soft`` whether the thing bends; ``left`` and ``others`` points that move beside it
    and are nobody's, and another's, over its own; ``tall`` its height over its model's; ``bend``
    share that one motion does not explain; ``coarse`` its unit, over its radius; ``border`` share
    of its points that touch moving ones that are nobody's.
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
    usual: float = USUAL
    points: int = MANY
    pixels: bool = True
    scans: bool = False
    soft: bool = False
    left: float = 0.0
    others: float = 0.0
    tall: float = 1.0
    bend: float = 0.0
    coarse: float = 0.05
    border: float = 0.0


def likelihood(evidence: Evidence, body: bool = False) -> float:
    """0..1, of this frame by itself; ``body``: of a large thing before a known scene."""
    if evidence.coarse >= POINTLIKE:
        return 0.0
    if evidence.scans:
        return squashed(_scanned(evidence) - SCAN_MIDDLE, SCAN_STRETCH)
    features = np.array(
        [
            evidence.inliers,
            evidence.sure,
            evidence.gap,
            evidence.cost * min(1.0, USUAL / evidence.usual),
            min(evidence.fit, 1.0),
            abs(log_ratio(evidence.size, SIZE_MOST)),
            abs(log_ratio(evidence.change, CHANGE_MOST)),
            evidence.grown,
            float(evidence.whole),
            evidence.share,
            max(evidence.worn, WORN_LEAST),
        ]
    )
    if body:
        odds = float(BODY_WEIGHTS @ features) + BODY_OFFSET - BODY_MIDDLE
    else:
        odds = float(WEIGHTS @ features[:-1]) + OFFSET - MIDDLE
        odds -= BORDER * evidence.border
        odds -= SHRUNK * abs(log_ratio(evidence.size, SIZE_MOST)) if evidence.soft else 0.0
        if evidence.pixels:
            odds += FEW * min(0.0, log_ratio(evidence.points / MANY, POINTS_MOST))
    return squashed(odds)


def _scanned(evidence: Evidence) -> float:
    """Log odds of what a lidar saw."""
    features = [
        log_ratio(evidence.left, LEFT_MOST),
        log_ratio(evidence.others, LEFT_MOST),
        abs(log_ratio(evidence.tall, SIZE_MOST)),
        evidence.bend,
        log_ratio(evidence.coarse, COARSE_MOST),
        abs(log_ratio(evidence.change, CHANGE_MOST)),
        evidence.grown,
    ]
    return float(SCAN_WEIGHTS @ features) + SCAN_OFFSET


def squashed(odds: float, stretch: float = STRETCH) -> float:
    """The probability 0..1 of log odds that are stretched first: the logistic function."""
    return 1.0 / (1.0 + float(np.exp(np.clip(-stretch * odds, -ODDS_MOST, ODDS_MOST))))


def log_ratio(ratio: float, most: float) -> float:
    """The logarithm of a ratio, ``most`` either way."""
    return float(np.clip(np.log(max(ratio, RATIO_LEAST)), -most, most))
