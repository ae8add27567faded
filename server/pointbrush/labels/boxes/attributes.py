"""Attributes of boxes: defined in the workspace's taxonomy, checked in each request."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, delete, insert, select

from pointbrush.database.schema import box_attributes
from pointbrush.errors import BadInputError
from pointbrush.labels.boxes.maps import check_attributes
from pointbrush.values.taxonomy import MOST_ATTRIBUTES, NAME_LIMIT, BoxAttribute, Scope

BUILT_IN = {
    "occluded": "expected 0 (visible), 1 (partly occluded), 2 (largely occluded) or 3 (unknown)",
    "truncated": "expected 0 (fully in the picture) to 1 (outside)",
    "parked": "expected true or false",
}
"""Built-in attributes of boxes, for the track or a frame; the first two are from KITTI."""


def check_definition(attribute: BoxAttribute) -> None:
    """Raise BadInputError unless a definition fits its kind and no attribute is built in."""
    about = f"attribute {attribute.name[:NAME_LIMIT]}"
    choices = attribute.choices
    check_attributes(dict.fromkeys((attribute.name, *choices), True))
    if attribute.name in BUILT_IN:
        raise BadInputError(f"{about}: expected another name, this attribute is built in")
    count = len(set(choices))
    if count < len(choices) or (count > 0) != (attribute.kind == "choice"):
        raise BadInputError(f"{about}: expected different choices, and only for the kind choice")


def _check_value(attribute: BoxAttribute, value: Any) -> None:
    """Raise BadInputError unless a value is of the attribute's kind."""
    choices = attribute.choices
    kinds: dict[str, bool] = {
        "text": isinstance(value, str),
        "choice": value in choices,
        "number": isinstance(value, int | float) and not isinstance(value, bool),
        "yes/no": isinstance(value, bool),
    }
    if not kinds[attribute.kind]:
        expected = f"one of {', '.join(choices)}" if choices else attribute.kind
        raise BadInputError(f"attribute {attribute.name}: expected {expected}, got {value!r}")


def _check_built_in(name: str, value: Any) -> None:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    good = {
        "occluded": number and value in (0, 1, 2, 3),
        "truncated": number and 0 <= value <= 1,
        "parked": isinstance(value, bool),
    }
    if not good[name]:
        raise BadInputError(f"attribute {name}: {BUILT_IN[name]}, got {value!r}")


def check_given(known: Sequence[BoxAttribute], given: Mapping[str, Any], scope: Scope) -> None:
    """Check attributes of a request for a box, or its pose in a frame; None removes one.

    Raises BadInputError for an undefined attribute, another scope or another kind.
    """
    defined = {each.name: each for each in known}
    for name, value in given.items():
        if value is None:
            continue
        if name in BUILT_IN:
            _check_built_in(name, value)
            continue
        if name not in defined:
            names = ", ".join((*BUILT_IN, *defined))
            raise BadInputError(f"attributes: expected {names} (PUT /taxonomy adds), got {name!r}")
        if defined[name].scope != scope:
            raise BadInputError(
                f"attribute {name}: expected it for the {defined[name].scope}, got the {scope}'s"
            )
        _check_value(defined[name], value)


# ── in the database ──────────────────────────────────────────────────────────────────────────


def read_attributes(connection: Connection) -> list[BoxAttribute]:
    """Read the definitions, ordered by position."""
    rows = connection.execute(select(box_attributes).order_by(box_attributes.c.position))
    return [
        BoxAttribute(row.name, row.kind, row.scope, tuple(json.loads(row.choices))) for row in rows
    ]


def write_attributes(connection: Connection, wanted: Sequence[BoxAttribute]) -> None:
    """Replace the definitions.  Raises BadInputError for too many, or a repeated name."""
    if len({each.name for each in wanted}) < len(wanted) or len(wanted) > MOST_ATTRIBUTES:
        raise BadInputError(f"attributes: expected at most {MOST_ATTRIBUTES}, each name once")
    for each in wanted:
        check_definition(each)
    connection.execute(delete(box_attributes))
    rows = [
        {
            "name": each.name,
            "position": position,
            "kind": each.kind,
            "scope": each.scope,
            "choices": json.dumps(each.choices),
        }
        for position, each in enumerate(wanted)
    ]
    if rows:
        connection.execute(insert(box_attributes), rows)
