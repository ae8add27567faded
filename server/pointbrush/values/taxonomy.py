"""The classes of a workspace, and the attributes of boxes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from pointbrush.values.base import Body, Complete, Limits, Meanings, Value
from pointbrush.values.kinds import HIDDEN, VISIBLE, Sides

NAME = f"^[^{HIDDEN} ]{VISIBLE}*$"
"""No control characters, and no space in front."""
MOST_ATTRIBUTES = 64
"""Limit for a box, or for one of its poses."""
MOST_CHOICES = 60
NAME_LIMIT = 64
"""Longest name of an attribute, characters."""
TEXT_LIMIT = 200
"""Longest text value of an attribute, characters."""

CategoryNumber = Annotated[int, Limits(ge=1, le=65535)]
DatasetName = Annotated[str, Limits(pattern=r"^[a-z0-9][a-z0-9-]{0,63}$")]
DatasetNumber = Annotated[int, Limits(ge=0, le=65535)]
AttributeText = Annotated[str, Limits(min_length=1, max_length=NAME_LIMIT, pattern=NAME)]
AttributeKind = Annotated[
    Literal["text", "choice", "number", "yes/no"],
    Meanings(
        {
            "text": "any text",
            "choice": "one of ``choices``",
            "number": "a number",
            "yes/no": "true or false",
        }
    ),
]
Scope = Annotated[
    Literal["track", "frame"],
    Meanings({"track": "one value for the box", "frame": "one value in each frame"}),
]


@dataclass(frozen=True, slots=True)
class Category(Complete):
    """A class of the workspace; its number is the same in every export and never changes."""

    number: CategoryNumber
    """1 to 65535."""
    name: Annotated[str, Limits(min_length=1, max_length=256, pattern=NAME)]
    """Text that people see; a new name changes no number."""
    color: Annotated[str, Limits(pattern=r"^(#[0-9a-fA-F]{6})?$")] = ""
    """``#rrggbb``; empty: none."""
    datasets: Annotated[Mapping[DatasetName, DatasetNumber], Limits(max_length=64)] = field(
        default_factory=dict
    )
    """Its numbers in other datasets, by name of the dataset."""
    size: Sides | None = None
    """Mean length, width and height of its objects, metres; null: unknown or unchanged."""
    spread: Sides | None = None
    """Standard deviation of the size, metres; null: unknown or unchanged."""


@dataclass(frozen=True, slots=True)
class BoxAttribute(Complete):
    """An attribute that boxes may have beside ``occluded``, ``truncated`` and ``parked``."""

    name: AttributeText
    """Key in the ``attributes`` of a box or of its pose."""
    kind: AttributeKind
    """Type of its values."""
    scope: Scope = "track"
    """Place of its values."""
    choices: Annotated[tuple[AttributeText, ...], Limits(max_length=MOST_CHOICES)] = ()
    """Values of the kind ``choice``; other kinds have none."""


BoxAttributes = Annotated[tuple[BoxAttribute, ...], Limits(max_length=MOST_ATTRIBUTES)]


@dataclass(frozen=True, slots=True)
class Taxonomy(Value):
    """The classes of a workspace and the attributes of boxes; can be put into another workspace."""

    categories: tuple[Category, ...]
    """All classes, by number."""
    attributes: tuple[BoxAttribute, ...]
    """Attributes of boxes, in the order of the page."""


@dataclass(frozen=True, slots=True)
class TaxonomyChange(Body):
    """Classes to add, and new names, colours and sizes of existing classes."""

    categories: Annotated[tuple[Category, ...], Limits(max_length=65535)] = ()
    """Classes by their numbers; other classes do not change."""
    attributes: BoxAttributes | None = None
    """All attributes of boxes; null keeps the existing ones."""


@dataclass(frozen=True, slots=True)
class MergedCategories(Body):
    """Classes to merge into another class."""

    categories: Annotated[tuple[CategoryNumber, ...], Limits(min_length=1, max_length=65535)]
    """Numbers of the classes that are removed."""
