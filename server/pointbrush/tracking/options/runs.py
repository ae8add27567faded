"""Options of a run: the labels that go along, and jumps of the sensor."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.tracking.options.base import Options


@dataclass(frozen=True, slots=True)
class CompanionOptions(Options):
    """Which labels go along with those that a run is asked for, and how near they are followed."""

    most: int = 12
    """Labels that go along, the nearest: a correction among a hundred cars costs no more."""
    larger: float = 2.0
    """Times as large as the largest that is asked for: beyond, it is a floor or a wall."""
    near_radii: float = 0.25
    """Radii, and with the two below, around where a label is expected, within which it meets others
    that an earlier run found; farther away they keep their stored points and are not followed."""
    near_units: float = 4.0
    """Units of tolerance, likewise."""
    near_steps: float = 0.5
    """Times the label's speed, for each frame since it was seen, likewise."""
    sampled_points: int = 60
    """Points of a label by which that is told."""


@dataclass(frozen=True, slots=True)
class JumpOptions(Options):
    """When a sensor at rest has jumped, and how its jump is found."""

    stride_frames: int = 8
    """Frames between two that are compared; where they differ, those between are."""
    sampled_points: int = 500
    """Points of a frame that are looked for in another."""
    near_share: float = 0.03
    """Distance within which a point is found again, in median distances from the middle; at
    least ``near_spacings`` of what it is looked for in."""
    near_spacings: float = 3.0
    """Spacings of the other frame's points, likewise."""
    stays_share: float = 0.85
    """Share of the points that are found again while the sensor rests."""
    shifts: int = 4
    """Shifts from which frames are registered."""
    pixel_cells: float = 2.0
    """Size of a pixel of the correlation, in cells that the frames are thinned to."""
    side_pixels: int = 128
    """Pixels of the correlation along each side."""
    least_cells: float = 2.0
    """Cells by which the scenery lies elsewhere after a jump."""
    rest_share: float = 0.25
    """Share of that by which it may between the frames before and after it."""
    agreed_share: float = 0.5
    """Share of the surfaces that have to be in place after a jump was undone."""
    left_share: float = 0.75
    """Share of those that were out of place which may still be."""
    patience: int = 2
    """Times that the scenery goes away without a jump after which the sensor is one that moves."""
    sure: float = 0.8
    """Confidence at most of what is found in the first frame behind a jump."""
    reach_spacings: float = 2.5
    """Spacings within which points are an object's there: what does not move along is given up."""
