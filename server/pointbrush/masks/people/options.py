"""Every tunable number of the search for people, with its unit."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PeopleOptions:
    """Lengths in metres unless stated."""

    columns: int = 256
    """Width of the pictures in which surfaces are found, pixels; larger ones are thinned."""
    floor: float = 0.02
    """Height below which a point counts as floor."""
    gap: float = 0.015
    gap_share: float = 0.01
    """Distance of neighbouring pixels of one surface: ``gap`` plus a share of their depth."""
    smallest: float = 0.008
    """Least visible area of a surface, square metres."""
    widest: float = 1.6
    widest_share: float = 1.5
    """Largest extent in the plan of a person, and as a share of the visible height."""
    tallest: float = 2.3
    """Largest height of a person."""
    overhead: float = 2.0
    """Height above which no surface of a person begins."""
    top: float = 1.0
    """Least height of a person's upper end above the floor, unless the picture cuts it."""
    shortest: float = 0.4
    """Least height of the visible part of a person."""
    lowest: float = 0.6
    pixels_below: int = 3
    air_share: float = 0.8
    """Height from which a group may be in the air, number of pixels below it at which that is
    judged, and share of its columns that then show the background."""
    gap_between: float = 0.15
    body_apart: float = 0.45
    """Largest gap and distance of the middles, in the plan, of surfaces of one person."""
    body: float = 0.06
    """Least visible area of the largest surface of a person, square metres."""
    margins: tuple[float, ...] = (0.1, 0.3)
    """Margins around a person in the pictures for the model, as shares of the longer side."""
    most_looked: int = 12
    """Number of places in a frame that the model looks at, the nearest first."""
    doubt_from: float = 0.1
    doubt_to: float = 0.9
    """Mean probabilities of the largest surface beyond which the model looks only once."""
    least_sure: float = 0.4
    """Least mean probability of a person of the usual shape."""
    usual_top: float = 1.65
    usual_width: float = 0.4
    usual_area: float = 0.35
    """Usual height of the upper end, width of the body, and visible area (square metres)."""
    top_weight: float = 0.166
    width_weight: float = 0.285
    area_weight: float = 0.046
    """Probability that a metre of height, a metre of width, and a factor e of area cost."""
    least_part: float = 0.4
    """Least mean probability of a surface of a person."""
    largest_step: float = 0.15
    least_resize: float = 0.6
    """Largest step of a surface between frames, and least ratio of its areas, to be the same."""
    new_share: float = 0.25
    """Share of new surfaces in a group from which the model looks at it again."""
    forgotten: int = 3
    looked_again: int = 15
    """Frames after which an unseen surface is forgotten, and a seen one looked at again."""
    steady_share: float = 0.5
    """Least share of a picture that has the same depth in another frame if the camera rests."""
    background_gap: float = 0.1
    """Least distance of the background behind a pixel that moved."""
    rest_window: int = 5
    """Width of the square in which most pixels must have rested, pixels."""
    moving_share: float = 0.3
    """Share of moved pixels from which a surface moves; furniture that it touches rests."""
    motion_weight: float = 0.8
    """Least probability of a surface that moved as a whole."""
    moving_top: float = 0.8
    moving_body: float = 0.02
    moving_sure: float = 0.3
    """``top``, ``body`` and ``least_sure`` of moving surfaces."""
    still_share: float = 0.06
    resting_cost: float = 0.7
    """Least share of moved pixels of a person, and the probability that a resting group costs."""
    compared_apart: float = 1.0
    """Least time between frames that are compared, seconds."""
    colour_step: float = 25.0
    """Largest distance of the colours of neighbouring pixels of one area, of 255 a channel."""
    thing: float = 0.35
    thing_area: float = 0.025
    """Mean probability below which an area may be a carried thing, and its least size (square
    metres)."""
    thing_low: float = 0.2
    thing_high: float = 0.9
    """Heights between which a carried thing such as a bag hangs from a hand."""
    sole: float = 0.02
    """Height below which nothing is added to feet."""
    outline: int = 1
    """Width of the outline that is added to a person, pixels."""
    outline_gap: float = 0.01
    """Largest distance of its pixels from the person, metres."""
