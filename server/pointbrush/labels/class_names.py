"""Names of classes: labels keep the key of a class, which never changes; people see its name.

The key of a class is the first name that it had.  So a new name changes one row of ``categories``,
and all that was written before follows: palettes, the journal, versions, backups, classifiers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import Connection, func, select

from pointbrush.labels.schema import categories

AGAIN = "\n"
"""Ends the key of a class whose name was the first one of another class; no name holds it."""
DELETED = 0
"""In place of the number of the class that a class was merged into."""
REVISION: Any = select(func.coalesce(func.max(categories.c.renamed), 0)).scalar_subquery()
"""Number of the last change of names and merges."""


@dataclass(frozen=True, slots=True)
class ClassNames:
    """Names of all classes as of change ``revision``.

    ``shown``: the name by key, for a merged class that of its target.  ``keys``: the key by name.
    A class that has no number yet has its name as key.
    """

    revision: int = 0
    shown: Mapping[str, str] = field(default_factory=dict)
    keys: Mapping[str, str] = field(default_factory=dict)

    def name(self, key: str) -> str:
        """Return the name of the class with this key."""
        return self.shown.get(key, key.rstrip(AGAIN))

    def key(self, name: str) -> str:
        """Return the key of the class of this name, a new one where no class has it."""
        if name in self.keys:
            return self.keys[name]
        key = name
        while key in self.shown:
            key += AGAIN
        return key

    def meaning(self, word: str) -> str:
        """Return the name of the class that a file means by a word: its name, or its first name."""
        return word if word in self.keys else self.name(word)

    def stored(self, fields: Mapping[str, Any]) -> dict[str, Any]:
        """Return fields of a label with the key of its category in place of the name."""
        return with_category(fields, self.key)

    def read(self, fields: Mapping[str, Any]) -> dict[str, Any]:
        """Return fields of a label as ``stored`` keeps them, with the name of its category."""
        return with_category(fields, self.name)


def with_category(fields: Mapping[str, Any], made: Callable[[str], str]) -> dict[str, Any]:
    """Return fields of a label with what is ``made`` of their category, if they have one."""
    category = fields.get("category")
    return {**fields, "category": made(category)} if category else dict(fields)


def read_names(connection: Connection) -> ClassNames:
    """Read the names of all classes."""
    columns = categories.c
    rows = connection.execute(
        select(columns.number, columns.key, columns.name, columns.merged, columns.renamed)
    ).all()
    by_number = {row.number: row for row in rows}
    shown = {row.key: by_number[row.merged or row.number].name for row in rows}
    keys = {row.name: row.key for row in rows if not row.merged}
    return ClassNames(max((row.renamed for row in rows), default=0), shown, keys)
