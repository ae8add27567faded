"""The classes of a workspace, read together, changed in memory and written together."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from sqlalchemy import and_, bindparam, delete, func, insert, or_, select
from sqlalchemy.engine import Connection

from pointbrush.database.class_names import DELETED, KEY_SUFFIX, read_names
from pointbrush.database.schema import categories, dataset_numbers, labels, sequences
from pointbrush.errors import ConflictError, NotFoundError
from pointbrush.formats.tables.numbering import Numbering, official_numbers, plain
from pointbrush.values import taxonomy as values

GREATEST = 65535
"""Greatest number of a category: SemanticKITTI keeps it in 16 bits."""


@dataclass(frozen=True, slots=True)
class Category(values.Category):
    """A class as the database has it; ``stated``: datasets with a number that a person set.

    The other fields are as in the schema.
    """

    key: str = field(default="", compare=False)
    merged: int | None = field(default=None, compare=False)
    renamed: int = field(default=0, compare=False)
    stated: Collection[str] = field(default=(), compare=False)

    def numbered(self, numbers: Mapping[str, int], stated: Collection[str] = ()) -> Category:
        """Return a copy with further numbers in datasets."""
        kept = {*self.stated, *stated}
        return replace(self, datasets={**self.datasets, **numbers}, stated=kept)

    def without(self, names: Collection[str]) -> Category:
        """Return a copy without numbers in the datasets of these names."""
        return replace(self, datasets={d: n for d, n in self.datasets.items() if d not in names})

    def is_called(self, word: str) -> bool:
        """Return whether ``word`` is the name or the first name, in any spelling."""
        return plain(word) in (plain(self.name), plain(self.key))


class Classes:
    """All categories, including merged and deleted ones; ``write`` saves the changes."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.names = read_names(connection)
        self._before = {entry.number: entry for entry in _read(connection)}
        self._rows: dict[int, Category] = {}
        self._keys: dict[str, int] = {}
        self._held: dict[tuple[str, int], int] = {}
        self.changed: set[int] = set()
        """Numbers of the changed categories."""
        for entry in self._before.values():
            self.change(entry)
        self.changed.clear()

    def all(self) -> list[Category]:
        """Return all categories, by number."""
        return [self._rows[number] for number in sorted(self._rows)]

    def shown(self) -> list[Category]:
        """Return the categories that are neither merged nor deleted, by number."""
        return [entry for entry in self.all() if entry.merged is None]

    def require(self, number: int) -> Category:
        """Return a shown category; raises NotFoundError."""
        entry = self._rows.get(number)
        if entry is None or entry.merged is not None:
            raise NotFoundError(f"category: expected a number of the taxonomy, got {number}")
        return entry

    def now(self, entry: Category) -> Category:
        """Return the target of a merged category, or else the category itself."""
        return self._rows[entry.merged or entry.number]

    def get(self, name: str, wish: int = 0) -> Category:
        """Return the category of a name; a new one gets the number ``wish`` if that is free."""
        key = self.names.key(name)
        if key in self._keys:
            entry = self._rows[self._keys[key]]
            return entry if entry.merged is None else self.change(replace(entry, merged=None))
        free = 1 <= wish <= GREATEST and wish not in self._rows
        number = wish if free else max(self._rows, default=0) + 1
        if number > GREATEST:
            raise ConflictError(f"categories: expected at most {GREATEST}, got one more")
        return self.change(Category(number, name, key=key))

    def change(self, entry: Category) -> Category:
        """Replace the category with this number, or add it."""
        before = self._rows.get(entry.number, entry)
        for there in before.datasets.items() - entry.datasets.items():
            del self._held[there]
        self._held |= dict.fromkeys(entry.datasets.items(), entry.number)
        self._rows[entry.number] = entry
        self._keys[entry.key] = entry.number
        self.changed.add(entry.number)
        return entry

    # ── numbers in datasets ──────────────────────────────────────────────────────────────

    def holder(self, dataset: str, number: int) -> Category | None:
        """Return the category with a number in a dataset; it may be a merged one."""
        return self._rows.get(self._held.get((dataset, number), 0))

    def numbers_in(self, dataset: str) -> dict[str, int]:
        """Return all numbers in a dataset by name, including those of merged categories."""
        return {e.name: e.datasets[dataset] for e in self.all() if dataset in e.datasets}

    def complete(self, numbering: Numbering, wanted: Iterable[Category]) -> None:
        """Assign numbers in a numbering to the categories of ``wanted`` without one."""
        fresh = {e.name: e for e in wanted if numbering.name not in e.datasets}
        own = {name: entry.number for name, entry in fresh.items()}
        found = numbering.completed(self.numbers_in(numbering.name), own)
        for name in fresh.keys() & found.keys():
            self.change(fresh[name].numbered({numbering.name: found[name]}))

    def give(self, dataset: str, number: int, entry: Category) -> bool:
        """Set a class's number in a dataset's files; return False if another class keeps it."""
        listed = official_numbers(dataset)
        official = number in (listed.get(plain(entry.name)), listed.get(plain(entry.key)))
        holder = self.holder(dataset, number)
        if holder is not None:
            if self.now(holder).number == entry.number:
                return True
            if not official or dataset in holder.stated:
                return False
            self.change(holder.without([dataset]))
        if dataset not in entry.datasets or (official and dataset not in entry.stated):
            self.change(entry.numbered({dataset: number}))
        return True

    # ── names ────────────────────────────────────────────────────────────────────────────

    def put(self, wanted: values.Category) -> None:
        """Add a category or change the one with its number; raises ConflictError."""
        known = self._rows.get(wanted.number)
        if known is None:
            known = Category(wanted.number, wanted.name, key=self._free_key(wanted.name))
        elif known.merged:
            raise ConflictError(
                f"number: expected one of the taxonomy, {known.number} was merged into "
                f"{known.merged}"
            )
        elif known.name != wanted.name:
            self._make_way(wanted)
        news = {d: n for d, n in wanted.datasets.items() if known.datasets.get(d) != n}
        for dataset, number in news.items():
            holder = self.holder(dataset, number)
            if holder is not None and holder.merged is None:
                raise held(dataset, number, holder, wanted.name)
            if holder is not None:
                self.change(holder.without([dataset]))
        entry = replace(
            known,
            name=wanted.name,
            color=wanted.color,
            size=wanted.size or known.size,
            spread=wanted.spread or known.spread,
            merged=None,
        )
        self.change(entry.numbered(news, news))

    def merge(self, target: Category, other: Category) -> None:
        """Merge a class into a target, which inherits numbers in datasets where it has none."""
        news = {d: n for d, n in other.datasets.items() if d not in target.datasets}
        self._point(other.without(news), target.number)
        self.change(target.numbered(news, news.keys() & set(other.stated)))

    def _point(self, other: Category, number: int) -> None:
        """Mark a class, and all classes merged into it, as merged into the one with ``number``."""
        for each in self.all():
            if each.merged == other.number:
                self.change(replace(each, merged=number))
        self.change(replace(other, merged=number, name=f"\n{other.number}"))

    def _make_way(self, wanted: values.Category) -> None:
        """Merge the deleted class with the new name of a class into this class.

        Raises ConflictError if labels use a category of this name that has no number yet.
        """
        key = self.names.key(wanted.name)
        there = self._rows.get(self._keys.get(key, 0))
        if there is not None and there.merged == DELETED:
            self._point(there, wanted.number)
        if there is None and key in self.used:
            raise ConflictError(
                f"name: expected one that labels of no other category have, got '{wanted.name}': "
                "merge the two (GET /taxonomy gives both numbers)"
            )

    def _free_key(self, name: str) -> str:
        while name in self._keys:
            name += KEY_SUFFIX
        return name

    @cached_property
    def used(self) -> set[str]:
        """Keys of all categories that labels use."""
        keys = self.connection.execute(select(labels.c.category).distinct()).scalars()
        return set(keys) - {""}

    def labels_of(self, entry: Category) -> dict[str, int]:
        """Count the labels of a class by recording, including deleted recordings."""
        keys = {key for key, name in self.names.shown.items() if name == entry.name}
        words = {word for word in {*keys, entry.name} if self.names.meaning(word) == entry.name}
        alone = and_(labels.c.category == "", labels.c.name.in_(words))
        query = (
            select(sequences.c.id, func.count())
            .join(labels, labels.c.sequence == sequences.c.number)
            .where(or_(labels.c.category.in_(keys), alone))
            .group_by(sequences.c.id)
        )
        return {str(name): int(count) for name, count in self.connection.execute(query)}

    # ── the database ─────────────────────────────────────────────────────────────────────

    def write(self) -> bool:
        """Write the changes; return whether names of existing classes changed."""
        if not self.changed:
            return False
        news = {n: self._rows[n] for n in sorted(self.changed)}
        for number, entry in news.items():
            before = self._before.get(number, entry)
            if (entry.name, entry.merged) != (before.name, before.merged):
                news[number] = replace(entry, renamed=self.names.revision + 1)
        numbers = [{"changed": number} for number in news]
        for column in (dataset_numbers.c.category, categories.c.number):
            gone = delete(column.table).where(column == bindparam("changed"))
            self.connection.execute(gone, numbers)
        for table, rows in (
            (categories, [_row(entry) for entry in news.values()]),
            (dataset_numbers, [row for entry in news.values() for row in _number_rows(entry)]),
        ):
            if rows:
                self.connection.execute(insert(table), rows)
        return any(entry.renamed > self.names.revision for entry in news.values())


def held(dataset: str, number: int, holder: Category | None, name: str) -> ConflictError:
    """Return the error for a number of a dataset that another category holds."""
    return ConflictError(
        f"{dataset}: expected number {number} to be that of one category, category "
        f"{holder and holder.number} has it, got '{name}'"
    )


def _read(connection: Connection) -> Iterator[Category]:
    numbers: dict[int, list[Any]] = {}
    for row in connection.execute(select(dataset_numbers).order_by(dataset_numbers.c.dataset)):
        numbers.setdefault(row.category, []).append(row)
    for entry in connection.execute(select(categories)).mappings():
        known = numbers.get(entry["number"], [])
        yield Category(
            **{**entry, "size": _size(entry["size"]), "spread": _size(entry["spread"])},
            datasets={each.dataset: each.number for each in known},
            stated={each.dataset for each in known if each.stated},
        )


def _size(stored: str | None) -> tuple[float, float, float] | None:
    if stored is None:
        return None
    length, width, height = json.loads(stored)
    return length, width, height


def _row(entry: Category) -> dict[str, Any]:
    row = {column.name: getattr(entry, column.name) for column in categories.c}
    return row | {side: row[side] and json.dumps(row[side]) for side in ("size", "spread")}


def _number_rows(entry: Category) -> list[dict[str, Any]]:
    return [
        {"category": entry.number, "dataset": name, "number": n, "stated": name in entry.stated}
        for name, n in entry.datasets.items()
    ]
