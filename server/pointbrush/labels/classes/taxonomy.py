"""The classes of a workspace: a category has one permanent number in all recordings."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import NamedTuple, TypeVar

from sqlalchemy import text

from pointbrush.database.class_names import DELETED
from pointbrush.database.database import Database
from pointbrush.database.statements import driver_of
from pointbrush.errors import BadInputError, ConflictError, ReadOnlyError, UnavailableError
from pointbrush.formats.tables.datasets import DATASETS
from pointbrush.formats.tables.numbering import Numbering, official_numbers, plain
from pointbrush.labels.boxes.attributes import read_attributes, write_attributes
from pointbrush.labels.classes.changes import GREATEST, Category, Classes, held
from pointbrush.labels.open_recordings import OpenRecordings
from pointbrush.labels.types import Label
from pointbrush.names import composed, require_visible
from pointbrush.values import taxonomy as values
from pointbrush.values.kinds import LONGEST_SIDE

LONGEST = 256
"""Longest name, characters."""
MOST_LISTED = 5
"""Limit of recordings listed in an error."""
_DATASET = re.compile("[a-z0-9][a-z0-9-]{0,63}")
T = TypeVar("T")


class Numbers(NamedTuple):
    """Numbers of classes by name: ``own`` in the workspace, ``datasets`` in each dataset."""

    own: dict[str, int]
    datasets: dict[str, dict[str, int]]


class Taxonomy:
    """The categories of one database; thread-safe."""

    def __init__(self, database: Database, open_recordings: OpenRecordings) -> None:
        self._database, self._open_recordings = database, open_recordings

    def entries(self) -> list[Category]:
        """Return all categories, by number."""
        with self._database.read() as connection:
            return Classes(connection).shown()

    def listed(self) -> list[Category]:
        """Return all categories; categories of labels get a number if they have none."""
        with self._database.read() as connection:
            classes = Classes(connection)
            names = sorted(map(classes.names.name, classes.used))
        self.numbers(names)
        return self.entries()

    def value(self) -> values.Taxonomy:
        """Return the classes and the attributes of boxes."""
        return values.Taxonomy(tuple(self.listed()), tuple(self.attributes()))

    def attributes(self) -> list[values.BoxAttribute]:
        """Return the attributes that boxes may have besides the built-in ones."""
        with self._database.read() as connection:
            return read_attributes(connection)

    def numbers(self, names: Iterable[str]) -> dict[str, int]:
        """Return the number of each name; new names get the next ones, in their order.

        For a read-only database, new names have the numbers that they would get.
        """
        wanted = list(dict.fromkeys(names))
        return self._given(lambda classes: {name: classes.get(name).number for name in wanted})

    def exported(self, palette: Iterable[Label], numbering: Numbering | None) -> Numbers:
        """Return the permanent numbers of the classes of labels, assigning missing ones.

        They are the numbers in the workspace, in known datasets, and in ``numbering``; a class has
        no number there if none is free.  A label without a category belongs to the class with the
        label's name as its name or first name.  A read-only database is treated as in ``numbers``.
        """
        words: dict[str, str] = {}
        for label in sorted(palette, key=lambda each: each.id):
            word = label.category or label.name
            words[word] = words.get(word) or label.category

        def give(classes: Classes) -> Numbers:
            meant = {w: classes.get(name or classes.names.meaning(w)) for w, name in words.items()}
            if numbering is not None:
                classes.complete(numbering, meant.values())
            own = {word: entry.number for word, entry in meant.items()}
            datasets = {}
            for dataset in {*DATASETS, *((numbering.name,) if numbering else ())}:
                known = classes.numbers_in(dataset)
                called = {word: known.get(entry.name) for word, entry in meant.items()}
                datasets[dataset] = known | {w: n for w, n in called.items() if n is not None}
            return Numbers(own, datasets)

        return self._given(give)

    def known_classes(self, dataset: str, words: Mapping[int, str]) -> dict[int, str]:
        """Return the names of the workspace's classes for numbers of a dataset.

        ``words``: the name of each number in the files.  A number is left out if this is not its
        official name, or if a class has the number only from files that use another name for it.
        """
        listed = official_numbers(dataset)
        with self._database.read() as connection:
            classes = Classes(connection)
        holders = {number: classes.holder(dataset, number) for number in words}
        return {
            number: classes.now(holder).name
            for number, holder in holders.items()
            if holder is not None
            and listed.get(plain(words[number])) == number
            and (dataset in holder.stated or holder.is_called(words[number]))
        }

    def learn(self, dataset: str, numbers: Mapping[str, int], *, strict: bool = True) -> None:
        """Store the number of each named category in a dataset; a stored number is kept.

        New categories get the same number in the workspace if it is free.  A class with an official
        name takes its official number from another class, unless a person has set it for that
        class.  Raises ConflictError for a number of the dataset that another category has; or, not
        ``strict``, skips it.
        """
        with self._changing() as classes:
            meant = {classes.names.meaning(name): number for name, number in numbers.items()}
            taken = {entry.number for entry in classes.all()}
            # Classes with a free number first, so that no other class takes it.
            fresh = sorted(meant, key=lambda name: meant[name] in taken)
            _check([classes.get(name, meant[name]) for name in fresh])
            for name, number in meant.items():
                if not classes.give(dataset, number, classes.get(name)) and strict:
                    raise held(dataset, number, classes.holder(dataset, number), name)

    def put(
        self,
        wanted: Sequence[values.Category],
        attributes: Sequence[values.BoxAttribute] | None = None,
    ) -> list[Category]:
        """Add categories, and set the names and colours of categories with known numbers.

        Numbers in datasets and sizes are added or changed; ``attributes`` of boxes replace the
        current ones, None keeps them.  Raises BadInputError for an invalid or repeated number or
        name, ConflictError for a name with another number, as numbers never change, or for a number
        of a dataset that another category has.
        """
        wanted = [replace(each, name=composed(each.name)) for each in wanted]
        _check(wanted)
        numbers = {each.number for each in wanted}
        with self._changing() as classes:
            known = classes.all()
            taken = {entry.name: entry for entry in known if entry.number not in numbers}
            before = {entry.number for entry in known}
            for each in wanted:
                holder = taken.get(each.name)
                # An existing class may take the name of a deleted class, a new number may not.
                if holder is not None and (holder.merged is None or each.number not in before):
                    raise ConflictError(
                        f"name: expected '{each.name}' to keep its number {holder.number}, "
                        f"got {each.number}"
                    )
                classes.put(each)
            if attributes is not None:
                write_attributes(classes.connection, attributes)
            return classes.shown()

    def merge(self, number: int, others: Sequence[int]) -> None:
        """Merge other categories into this one: their labels become labels of this category.

        It inherits numbers in datasets where it has none.  Raises NotFoundError, and BadInputError
        if a number is repeated or is the category itself.
        """
        if not others or number in others or len(set(others)) < len(others):
            raise BadInputError(
                f"categories: expected others than {number}, each once, got {list(others)[:20]}"
            )
        with self._changing() as classes:
            for other in others:
                classes.merge(classes.require(number), classes.require(other))

    def remove(self, number: int) -> None:
        """Delete an unused category; its number is used again only for the same name.

        Raises NotFoundError, ConflictError if labels use it, also in deleted recordings.
        """
        with self._changing() as classes:
            entry = classes.require(number)
            if used := classes.labels_of(entry):
                named = ", ".join(sorted(used)[:MOST_LISTED]) + (
                    ", …" if len(used) > MOST_LISTED else ""
                )
                raise ConflictError(
                    f"category: expected one that no label uses, '{entry.name}' has "
                    f"{sum(used.values())} labels (recordings: {named}); merge it into another one"
                )
            classes.change(replace(entry, merged=DELETED))

    def _given(self, give: Callable[[Classes], T]) -> T:
        """Return the numbers that ``give`` assigns; keep them unless the database is read-only."""
        with self._database.read() as connection:
            classes = Classes(connection)
            given = give(classes)
        if classes.changed:
            with suppress(ReadOnlyError), self._changing() as classes:
                given = give(classes)
        return given

    @contextmanager
    def _changing(self) -> Iterator[Classes]:
        """Yield the categories, locked against other writers, and write the changes at the end.

        Raises ReadOnlyError.
        """
        with self._database.write() as connection:
            if not self._database.sqlite:  # it has one writer at a time
                connection.execute(text("LOCK TABLE categories IN SHARE ROW EXCLUSIVE MODE"))
            classes = Classes(connection)
            yield classes
            if renamed := classes.write():
                self._open_recordings.watcher.announce(driver_of(connection))
        if renamed:
            with suppress(UnavailableError):  # the watcher catches up later
                self._open_recordings.catch_up()


def _check(wanted: Sequence[values.Category]) -> None:
    numbers, names = [each.number for each in wanted], [each.name for each in wanted]
    for each in wanted:
        if not 1 <= each.number <= GREATEST:
            raise BadInputError(f"number: expected 1 to {GREATEST}, got {each.number}")
        if not each.name.strip() or len(each.name) > LONGEST:
            raise BadInputError(
                f"name: expected 1 to {LONGEST} characters, got {len(each.name)} for number "
                f"{each.number}"
            )
        require_visible("name", each.name)
        for name, size in (("size", each.size), ("spread", each.spread)):
            if size is not None and not all(0 < side <= LONGEST_SIDE for side in size):
                raise BadInputError(
                    f"{name}: expected length, width, height above 0 m and at most "
                    f"{LONGEST_SIDE:,.0f}, got {size} for '{each.name}'"
                )
        for dataset, number in each.datasets.items():
            if not _DATASET.fullmatch(dataset) or not 0 <= number <= GREATEST:
                raise BadInputError(
                    f"datasets: expected names of letters, digits and '-' with numbers 0 to "
                    f"{GREATEST}, got {dataset[:40]!r}: {number}"
                )
    if len(set(numbers)) != len(numbers) or len(set(names)) != len(names):
        raise BadInputError("categories: expected each number and each name once")
