"""Options of confidence: logistic regressions of named features."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from pointbrush.tracking.options.base import Options, PositiveFloat, PositiveInt, Weights


@dataclass(frozen=True, slots=True)
class FitWeights(Weights):
    """Of small objects before a camera, and others; features as of `Evidence`."""

    inliers: float = 3.96
    sure: float = 3.75
    gap: float = -5.25
    cost: float = -2.25
    fit: float = -1.5
    size: float = -1.605
    change: float = 0.315
    grown: float = -6.0
    isolated: float = 2.685
    share: float = -0.765
    beside: float = -40.0


@dataclass(frozen=True, slots=True)
class BodyWeights(Weights):
    """Of bodies before a known scene."""

    inliers: float = 2.07
    gap: float = -4.92
    cost: float = -1.125
    size: float = -2.595
    change: float = -1.5
    share: float = 4.545
    appearance: float = 2.64


@dataclass(frozen=True, slots=True)
class ScanWeights(Weights):
    """Of scanned tracks."""

    left: float = -1.8
    others: float = -0.6
    tall: float = -3.06
    bend: float = -10.76
    coarse: float = -1.3
    change: float = -1.26
    grown: float = -8.34


@dataclass(frozen=True, slots=True)
class ConfidenceOptions(Options):
    """Calibrated confidence: logistic regression of named features."""

    signed: ClassVar[frozenset[str]] = frozenset({"scan_offset", "min_log_clothes"})

    weights: FitWeights = field(default_factory=FitWeights)
    offset: float = 3.18  # log odds that are added
    body_weights: BodyWeights = field(default_factory=BodyWeights)
    body_offset: float = 5.235  # log odds that are added for bodies
    scan_weights: ScanWeights = field(default_factory=ScanWeights)
    scan_offset: float = -6.1  # log odds that are added for scanned tracks
    many_points: PositiveInt = 300  # points from which a fit before a pixel grid is told apart well
    few_weight: float = 3.75  # weight of the log share of them that there are
    pointlike_ratio: float = 1.0  # units over radius from which an object is one place
    bent_change_weight: float = 5.25  # weight of a changed size of a bending object
    usual_beside: float = 0.12  # ratio of touching points that a hand may have
    # Usual cost from which a track's cost counts as a multiple of it.
    usual_cost: PositiveFloat = 1.2
    max_log_size: float = 2.0  # greatest log ratio of size and height
    max_log_change: float = 1.0  # greatest log ratio of a sudden change of size
    max_log_left: float = 4.0  # greatest log ratio of points left beside it to its own
    max_log_coarse: float = 6.0  # greatest log of how coarsely it is seen
    min_log_clothes: float = -3.0  # least mean log ratio of clothes
    regain: float = 0.15  # confidence that a frame can give back
    regain_scanned: float = 0.03  # the same for scanned tracks


@dataclass(frozen=True, slots=True)
class PersonWeights(Weights):
    """Of people; features as of `PersonEvidence`."""

    fit: float = -0.5
    disputed: float = -3.0
    size: float = -1.2
    change: float = -0.3
    like: float = 1.0
    back: float = -0.5
    touching: float = -5.0
    wider: float = -20.0
    astray: float = -1.4


@dataclass(frozen=True, slots=True)
class PersonConfidenceOptions(Options):
    """Confidence of a person, the same way."""

    weights: PersonWeights = field(default_factory=PersonWeights)
    offset: float = 3.0  # log odds that are added
    max_log_size: float = 4.0  # greatest log ratio of size


@dataclass(frozen=True, slots=True)
class IcpWeights(Weights):
    """Of `icp` and `color-icp`; features as of `IcpEvidence`."""

    residual: float = -1.22
    found: float = 3.56
    beyond: float = -4.89


@dataclass(frozen=True, slots=True)
class IcpConfidenceOptions(Options):
    """Confidence of `icp` and `color-icp`: logistic regression of named features."""

    signed: ClassVar[frozenset[str]] = frozenset({"offset"})

    weights: IcpWeights = field(default_factory=IcpWeights)
    offset: float = -1.75  # log odds that are added
    on_spacings: float = 2.0  # spacings from a point within which another lies on it
    max_log_residual: float = 3.0  # greatest log of a residual in spacings
    regain: float = 0.15  # confidence that a frame can give back
