"""People found in colour pictures, without a click."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pointbrush.values.base import Body, Rule, Value
from pointbrush.values.kinds import FrameIndex, Uuid
from pointbrush.values.objects import PointRuns

MOST_SHOWN = 100
"""Largest number of frames of a search that changes nothing."""


@dataclass(frozen=True, slots=True)
class PeopleSearch(Body):
    """Frames to search for people."""

    frames: Annotated[tuple[FrameIndex, ...], Rule(min_length=1, max_length=100_000)] | None = None
    """Numbers of the frames; null: all frames."""
    apply: bool = False
    """True: label the people, as one edit in a job; false: only return them."""
    id: Uuid | None = None
    """UUID of the job and of its edit; a repeated call does not start another job."""


@dataclass(frozen=True, slots=True)
class LabelledPeople(Value):
    """Result of a job that labels people."""

    edit: str | None
    """UUID of the edit; null: no people were found."""
    changed: int
    """Number of points with a new label."""
    people: int
    """Number of labelled people."""


@dataclass(frozen=True, slots=True)
class PersonPoints(PointRuns):
    """Points of a person in a frame."""

    frame: int
    """Number of the frame."""
    score: float
    """Mean probability of the person's points, 0 to 1."""
    points: int
    """Number of the person's points."""
    runs: tuple[tuple[int, int], ...]
    """Runs of these points: first number and length."""


@dataclass(frozen=True, slots=True)
class FoundPerson(Value):
    """A person in the searched frames."""

    name: str
    """Name of the label that the person gets."""
    color: str
    """Colour of this label."""
    label: int | None
    """Id of this label; null: a new one."""
    frames: tuple[PersonPoints, ...]
    """The person's points in each frame with the person, in the order of the frames."""


@dataclass(frozen=True, slots=True)
class FoundPeople(Value):
    """People in the searched frames; no label was changed."""

    category: str
    """Class of their labels."""
    searched: int
    """Number of searched frames."""
    people: tuple[FoundPerson, ...]
    """The people, the nearest first."""
