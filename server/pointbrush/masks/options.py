"""Tunable numbers of masks, by step."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class VisibilityOptions:
    """Depth buffer of the frame's own points."""

    depth_tolerance: float = 0.04
    """Least difference of depths between two surfaces, as a share of the depth."""
    least_gap: float = 0.03
    """Least difference of depths between two surfaces, metres."""
    reach: float = 2.5
    """Distance at which points count as neighbours, in spacings of the points in the picture."""
    least_reach: float = 2.0
    """Lower bound of this distance, pixels."""
    most_reach: float = 24.0
    """Upper bound of this distance, pixels."""


@dataclass(frozen=True, slots=True)
class LiftOptions:
    """Numbers of ``lift``."""

    visibility: VisibilityOptions = field(default_factory=VisibilityOptions)
    pixel_error: float = 1.0
    """Error of a camera's calibration and of mask borders, pixels."""
    metre_error: float = 0.02
    """Error of a camera's position, metres."""
    neighbours: int = 5
    """Number of the certain points nearest to a doubtful one that decide about it."""
    most_distance: float = 2.5
    """Distance of these points, in widths of the doubtful band at the point."""


@dataclass(frozen=True, slots=True)
class DrawOptions:
    """Numbers of ``draw``."""

    visibility: VisibilityOptions = field(default_factory=VisibilityOptions)
    most_gap: int = 12
    """Most pixels between two points of one surface that are filled."""
