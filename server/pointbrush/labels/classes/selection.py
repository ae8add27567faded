"""The categories of the workspace that a recording's project has selected."""

from __future__ import annotations

import json
from collections.abc import Iterable

from sqlalchemy import Connection, select

from pointbrush.database.class_names import read_names
from pointbrush.database.project_tables import projects
from pointbrush.database.schema import PROJECT_OF, categories, sequences
from pointbrush.errors import BadInputError
from pointbrush.labels.types import Label

MOST_LISTED = 20
"""Limit of categories listed in an error."""


def selected(connection: Connection, sequence: int) -> frozenset[str] | None:
    """Return the names of the selected categories of a recording's project; None: all."""
    query = select(projects.c.categories).join(sequences, projects.c.id == PROJECT_OF)
    chosen = connection.execute(query.where(sequences.c.number == sequence)).scalar()
    if chosen is None:
        return None
    numbers, names = set(json.loads(chosen)), read_names(connection)
    known = connection.execute(select(categories.c.number, categories.c.key))
    return frozenset(names.name(row.key) for row in known if row.number in numbers)


def allowed(
    connection: Connection, sequence: int, labels: Iterable[Label]
) -> frozenset[str] | None:
    """Return the categories that labels of a recording may have; None: all."""
    found = selected(connection, sequence)
    return None if found is None else found | {label.category for label in labels} | {""}


def require_allowed(categories: frozenset[str] | None, wanted: str) -> None:
    """Raise BadInputError unless labels may have the category ``wanted``."""
    if categories is not None and wanted not in categories:
        named = ", ".join(sorted(categories - {""})[:MOST_LISTED]) or "none"
        raise BadInputError(
            f"category: expected one that the project has selected ({named}), got {wanted!r}"
        )
