"""Options of visibility and of lifting masks."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class VisibilityOptions:
    """Options of ``visible``, the depth buffer of a frame's points."""

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
class AlignOptions:
    """Options of ``align``.  The error of the calibration at a point is ``metre_error`` plus
    ``pixel_error`` at its depth."""

    widest: float = 2.0
    """Greatest correction, in errors of the calibration."""
    steps: int = 3
    """Steps of the first search to each side, per axis."""
    prior: float = 0.05
    """Cost of an offset of one error of the calibration, as a share of the pairs that the best
    offset joins in comparison with the median of all."""
    finest: float = 0.05
    """Least step of the search, in errors of the calibration."""
    least_pairs: int = 40
    """Least number of pairs that the best offset joins in comparison with the median of all."""
    least_gain: float = 0.1
    """Least share of the divided pairs that a correction must join; otherwise the camera stays."""


@dataclass(frozen=True, slots=True)
class LiftOptions:
    """Options of ``lift``."""

    visibility: VisibilityOptions = field(default_factory=VisibilityOptions)
    align: AlignOptions = field(default_factory=AlignOptions)
    pixel_error: float = 1.0
    """Error of a camera's calibration and of mask borders, pixels."""
    metre_error: float = 0.02
    """Error of a camera's position, metres."""
    aligned_error: float = 0.25
    """Share of the error of position that is left after an alignment."""
    neighbours: int = 5
    """Number of the nearest certain points that decide about a point near a border."""
    most_distance: float = 2.5
    """Greatest distance of these points, in widths of the band along the border."""
