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
"""Maximum rays of one object, of each kind."""
MOST_LEVELS = 6
"""Maximum candidates of one answer."""
MOST_NAME = 64
"""Maximum characters of a candidate's id."""


def _by_candidate(_at: Selecting) -> Parts:
    raise BadInputError("shape: 'object' is taken by a candidate, not by its samples alone")


OBJECT = Shape(
    "object",
    "A candidate of the object tool; the samples are rays at the object.",
    (
        RADIUS,
        Parameter("negatives", Rays(MOST_RAYS), (), "rays at points that do not belong to it"),
        Parameter(
            "candidate",
            Text(MOST_NAME),
            "",
            "id of a candidate of the frame as it is now; the server refuses other ids (409)",
        ),
        Parameter(
            "level",
            Whole(0, MOST_LEVELS - 1),
            None,
            "without `candidate`: the level to take, from 0 (the smallest); null: the best",
        ),
        Parameter("previous", Text(MOST_NAME), "", "the candidate taken so far, as in the request"),
        Parameter("take_labelled", Flag(), False, "also points of other labels"),
        Parameter(
            "replaces",
            EditName(),
            None,
            "this author's last edit, which the stroke replaces: one undo reverts a refined object",
        ),
    ),
    take=_by_candidate,
)
