"""Names of classes: the database keeps the key of a class, which never changes; users see its name.

The key of a class is its first name.  Renaming a class changes one row of ``categories``; palettes,
the journal, versions, backups and classifiers hold the key and follow.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import Connection, func, select

from pointbrush.database.schema import categories

KEY_SUFFIX = "\n"
"""End of the key of a class whose name is the first name of another class; not valid in names."""
DELETED = 0
"""Value of ``merged`` of a deleted class; other values are the number of the target class."""
REVISION: Any = select(func.coalesce(func.max(categories.c.renamed), 0)).scalar_subquery()
"""Number of the last rename, merge or deletion."""


@dataclass(frozen=True, slots=True)
class ClassNames:
    """Names of all classes as of change ``revision``.

    ``shown``: name by key; a merged class has the name of its target.  ``keys``: key by name.
    The key of a class without a number is its name.
    """

    revision: int = 0
    shown: Mapping[str, str] = field(default_factory=dict)
    keys: Mapping[str, str] = field(default_factory=dict)

    def name(self, key: str) -> str:
        """Return the name of the class with this key."""
        return self.shown.get(key, key.rstrip(KEY_SUFFIX))

    def key(self, name: str) -> str:
        """Return the key of the class with this name, or a free key if there is none."""
        if name in self.keys:
            return self.keys[name]
        key = name
        while key in self.shown:
            key += KEY_SUFFIX
        return key

    def meaning(self, word: str) -> str:
        """Return the name of the class with the current or first name ``word`` in a file."""
        return word if word in self.keys else self.name(word)

    def stored(self, fields: Mapping[str, Any]) -> dict[str, Any]:
        """Return fields of a label with the key of its category in place of the name."""
        return with_category(fields, self.key)

    def read(self, fields: Mapping[str, Any]) -> dict[str, Any]:
        """Return stored fields of a label with the name of the category in place of the key."""
        return with_category(fields, self.name)


def with_category(fields: Mapping[str, Any], convert: Callable[[str], str]) -> dict[str, Any]:
    """Return fields of a label with ``convert`` applied to the category, if there is one."""
    category = fields.get("category")
    return {**fields, "category": convert(category)} if category else dict(fields)


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
