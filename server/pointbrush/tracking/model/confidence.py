"""Confidence: probability of a good label, learnt on generated recordings.

It is a logistic regression of an IoU above 0.8 on features of a fit, for table-top, juggling,
walking and lidar recordings.  Weights and offsets are scaled so that nearly all labels above 0.9
are good, and nearly all wrong labels are below 0.5.  Source: docs/tracking.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.options.confidence import ConfidenceOptions

RATIO_LEAST = 1e-3
"""Minimum ratio for logarithms."""
MOST_LOG_ODDS = 30.0
"""Limit of log odds, to keep the exponential finite."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """Features of a registered track, from which its confidence is computed.

    ``inliers``: matched share of the visible model; ``sure``: share of points on well confirmed
    surface; ``gap`` and ``cost``: mean distances to the model in position, and in position and
    colour, in reaches; ``fit``: cost of the registration; ``size`` and ``change``: number of points
    over the maximum and over the last; ``grown``: share of points that the model does not explain;
    ``isolated``: whether the object moves alone; ``share``: share of the moving points around;
    ``appearance``: mean log ratio, 0 or less, of a large object's colours to its painted ones;
    ``usual``: usual ``cost`` while the object was alone in the air; ``points``: their number;
    ``pixels``: whether the sensor has a pixel grid; ``scans``: whether it is a lidar; ``soft``:
    whether the object bends; ``left`` and ``others``: ratios of adjacent moving points, unassigned
    and of other tracks, to its own; ``tall``: its height over its model's; ``bend``: share that one
    motion does not explain; ``coarse``: its unit over its radius; ``beside``: ratio of unclaimed
    moving points that touch a small object to its own.
    """

    inliers: float
    sure: float
    gap: float
    cost: float
    fit: float
    size: float
    change: float
    grown: float
    isolated: bool
    share: float
    appearance: float
    usual: float
    points: int
    pixels: bool = True
    scans: bool = False
    soft: bool = False
    left: float = 0.0
    others: float = 0.0
    tall: float = 1.0
    bend: float = 0.0
    coarse: float = 0.05
    beside: float = 0.0


def likelihood(evidence: Evidence, body: bool = False, *, options: ConfidenceOptions) -> float:
    """Return the likelihood, 0 to 1, of this frame alone; ``body``: large, in a known scene."""
    if evidence.coarse >= options.pointlike_ratio:
        return 0.0
    features = _features(evidence, options)
    if evidence.scans:
        return squashed(options.scan_weights.odds(features) + options.scan_offset)
    if body:
        return squashed(options.body_weights.odds(features) + options.body_offset)
    odds = options.weights.odds(features) + options.offset
    if evidence.soft:
        odds -= options.bent_change_weight * features["size"]
    if evidence.pixels:
        few = log_ratio(evidence.points / options.many_points, np.inf)
        odds += options.few_weight * min(0.0, few)
    return squashed(odds)


def _features(evidence: Evidence, options: ConfidenceOptions) -> dict[str, float]:
    """Return the features with weights, by name."""
    return {
        "inliers": evidence.inliers,
        "sure": evidence.sure,
        "gap": evidence.gap,
        "cost": evidence.cost * min(1.0, options.usual_cost / evidence.usual),
        "fit": min(evidence.fit, 1.0),
        "size": abs(log_ratio(evidence.size, options.max_log_size)),
        "change": abs(log_ratio(evidence.change, options.max_log_change)),
        "grown": evidence.grown,
        "isolated": float(evidence.isolated),
        "share": evidence.share,
        "appearance": max(evidence.appearance, options.min_log_clothes),
        "left": log_ratio(evidence.left, options.max_log_left),
        "others": log_ratio(evidence.others, options.max_log_left),
        "tall": abs(log_ratio(evidence.tall, options.max_log_size)),
        "bend": evidence.bend,
        "coarse": log_ratio(evidence.coarse, options.max_log_coarse),
        "beside": max(evidence.beside - options.usual_beside, 0.0),
    }


def squashed(odds: float) -> float:
    """Return the probability of log odds, by the logistic function."""
    return 1.0 / (1.0 + float(np.exp(np.clip(-odds, -MOST_LOG_ODDS, MOST_LOG_ODDS))))


def log_ratio(ratio: float, most: float) -> float:
    """Return the logarithm of a ratio, clipped to ``most`` in both directions."""
    return float(np.clip(np.log(max(ratio, RATIO_LEAST)), -most, most))
