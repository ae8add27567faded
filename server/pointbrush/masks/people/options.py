"""Every tunable number of the search for people, with its unit."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PeopleOptions:
    """Lengths in metres unless stated."""

    columns: int = 256
    """Width of the pictures in which surfaces are found, pixels; larger ones are thinned."""
    floor: float = 0.04
    """Height below which a point counts as floor."""
    gap: float = 0.02
    gap_share: float = 0.01
    """Distance of neighbouring pixels of one surface: ``gap`` plus a share of their depth."""
    least_pixels: int = 40
    """Pixels of the smallest surface that is looked at."""
    widest: float = 1.6
    """Largest extent in the plan of a person."""
    tallest: float = 2.3
    """Largest height of a person."""
    top: float = 1.0
    """Least height of a person's upper end above the floor, unless the picture cuts it."""
    shortest: float = 0.4
    """Least height of the visible part of a person."""
    together: float = 0.25
    """Largest gap in the plan between surfaces of one person."""
    margin: float = 0.3
    """Margin around a person in the picture for the model, as a share of the longer side."""
    most_looked: int = 12
    """Number of places in a frame that the model looks at, the nearest first."""
    sure: float = 0.6
    """Least mean probability of a person."""
    part: float = 0.4
    """Least mean probability of a surface of a person."""
