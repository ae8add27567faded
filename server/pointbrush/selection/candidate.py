"""The brush shape ``object``: a candidate of the object tool."""

from __future__ import annotations

from pointbrush.errors import BadInputError
from pointbrush.selection.shape import (
    RADIUS,
    EditName,
    Flag,
    Parameter,
    Parts,
    Rays,
    Selecting,
    Shape,
    Text,
    Whole,
)

MOST_RAYS = 64
"""Rays of one object, of either kind."""
MOST_LEVELS = 6
"""Candidates of one answer."""
MOST_NAME = 64
"""Characters of a candidate's id."""


def _by_candidate(_at: Selecting) -> Parts:
    raise BadInputError("shape: 'object' is taken by a candidate, not by its samples alone")


OBJECT = Shape(
    "object",
    "A candidate of the object tool; the samples are rays at the object.",
    (
        RADIUS,
        Parameter("negatives", Rays(MOST_RAYS), (), "rays at what is no part of it"),
        Parameter(
            "candidate",
            Text(MOST_NAME),
            "",
            "the id of a candidate of the newest answer; another one is refused (409)",
        ),
        Parameter(
            "level",
            Whole(0, MOST_LEVELS - 1),
            None,
            "without `candidate`: the level to take, from 0, the smallest; null: the best",
        ),
        Parameter(
            "previous", Text(MOST_NAME), "", "the candidate taken so far, as it was asked with"
        ),
        Parameter("take_labelled", Flag(), False, "also points of other labels"),
        Parameter(
            "replaces",
            EditName(),
            None,
            "this author's last edit, taken back first, so that a refined object is one undo",
        ),
    ),
    take=_by_candidate,
)
