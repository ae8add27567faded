"""The brush shape ``object``: a candidate of the object tool."""

from __future__ import annotations

from typing import Annotated

from pointbrush.errors import BadInputError
from pointbrush.selection.shape import (
    FLAG,
    RADIUS,
    Kind,
    Parameter,
    Parts,
    Rays,
    Selecting,
    Shape,
)
from pointbrush.values.base import Rule
from pointbrush.values.kinds import Uuid

MOST_RAYS = 64
"""Maximum rays of one object, of each kind."""
MOST_LEVELS = 6
"""Maximum candidates of one answer."""
CANDIDATE_ID = Kind(Annotated[str, Rule(max_length=64)])


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
            CANDIDATE_ID,
            "",
            "id of a candidate of the frame as it is now; the server refuses other ids (409)",
        ),
        Parameter(
            "level",
            Kind(Annotated[int, Rule(ge=0, le=MOST_LEVELS - 1)]),
            None,
            "without `candidate`: the level to take, from 0 (the smallest); null: the best",
        ),
        Parameter("previous", CANDIDATE_ID, "", "the candidate taken so far, as in the request"),
        Parameter("take_labelled", FLAG, False, "also points of other labels"),
        Parameter(
            "replaces",
            Kind(Uuid),
            None,
            "this author's last edit, which the stroke replaces: one undo reverts a refined object",
        ),
    ),
    take=_by_candidate,
)
