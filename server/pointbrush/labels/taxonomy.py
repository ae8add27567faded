"""The classes of a workspace: a category has one number in all recordings, for ever."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from sqlalchemy import delete, insert, select, text, update
from sqlalchemy.engine import Connection

from pointbrush.errors import BadInputError, ConflictError, ReadOnlyError
from pointbrush.formats.numbering import Numbering
from pointbrush.labels.box_attributes import BoxAttribute, read_attributes, write_attributes
from pointbrush.labels.box_maps import LONGEST_SIDE
from pointbrush.labels.database import Database
from pointbrush.labels.schema import categories, dataset_numbers
from pointbrush.names import require_visible

GREATEST = 65535
"""Greatest number of a category: SemanticKITTI keeps it in 16 bits."""
LONGEST = 256
"""Characters of a name."""
_DATASET = re.compile("[a-z0-9][a-z0-9-]{0,63}")


Size = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Category:
    """A class: ``number`` 1..65535, ``name``, ``color`` ``#rrggbb`` or "".

    ``datasets`` are its numbers in the datasets that it is known from.  ``size``, length,
    width and height of its objects, and the standard deviation ``spread``, metres; None: unknown.
    """

    number: int
    name: str
    color: str = ""
    datasets: Mapping[str, int] = field(default_factory=dict)
    size: Size | None = None
    spread: Size | None = None


class Taxonomy:
    """The categories of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def entries(self) -> list[Category]:
        """Return all categories, by number."""
        with self._database.read() as connection:
            return _entries(connection)

    def attributes(self) -> list[BoxAttribute]:
        """Return the attributes that boxes may have, beside those that all have."""
        with self._database.read() as connection:
            return read_attributes(connection)

    def numbers(self, names: Iterable[str]) -> dict[str, int]:
        """Return the number of each name; new names get the next ones, in their order.

        Where nothing can be written the numbers of new names are those that they would get.
        """
        wanted = list(dict.fromkeys(names))
        known = {entry.name: entry.number for entry in self.entries()}
        fresh = [name for name in wanted if name not in known]
        if fresh:
            known |= self._given_out(fresh, known)
        return {name: known[name] for name in wanted}

    def _given_out(self, fresh: Sequence[str], known: dict[str, int]) -> dict[str, int]:
        try:
            with self._locked() as connection:
                known = {entry.name: entry.number for entry in _entries(connection)}
                given = _next(fresh, known)
                _insert(connection, [Category(given[n], n) for n in given if n not in known])
                return given
        except ReadOnlyError:
            return _next(fresh, known)

    @contextmanager
    def _locked(self) -> Iterator[Connection]:
        """A transaction in which nobody else changes categories; raises ReadOnlyError."""
        with self._database.write() as connection:
            if not self._database.sqlite:  # whose writers are one at a time
                connection.execute(text("LOCK TABLE categories IN SHARE ROW EXCLUSIVE MODE"))
            yield connection

    def known_as(self, dataset: str) -> dict[str, int]:
        """Return the numbers that categories have in a dataset, by name."""
        found = {entry.name: entry.datasets.get(dataset) for entry in self.entries()}
        return {name: number for name, number in found.items() if number is not None}

    def numbers_in(self, numbering: Numbering, names: Sequence[str]) -> dict[str, int]:
        """Numbers of categories in a numbering, which each is given once, for ever.

        Where nothing can be written they are those that the categories would get.  A category for
        which none is free has none.
        """

        def given(entries: Sequence[Category]) -> dict[str, int]:
            known = {
                e.name: e.datasets[numbering.name] for e in entries if numbering.name in e.datasets
            }
            own = {entry.name: entry.number for entry in entries}
            return numbering.completed(known, {name: own.get(name, 0) for name in names})

        self.numbers(names)
        entries = self.entries()
        found = given(entries)
        if any(numbering.name not in entry.datasets for entry in entries if entry.name in found):
            try:
                with self._locked() as connection:
                    entries = _entries(connection)
                    found = given(entries)
                    fresh = [
                        replace(entry, datasets={numbering.name: found[entry.name]})
                        for entry in entries
                        if entry.name in found and numbering.name not in entry.datasets
                    ]
                    _write_datasets(connection, fresh)
            except ReadOnlyError:
                pass
        return {name: found[name] for name in names if name in found}

    def learn(self, dataset: str, numbers: Mapping[str, int], *, strict: bool = True) -> None:
        """Keep the number that each named category has in a dataset; a known one stays.

        New categories get numbers of the workspace, those of the dataset where they are free.
        Raises ConflictError for a number of the dataset that another category has; or, not
        ``strict``, leaves that out.
        """
        with self._locked() as connection:
            entries = _entries(connection)
            known = {entry.name: entry for entry in entries}
            held = {e.datasets[dataset]: e.name for e in entries if dataset in e.datasets}
            if not strict:
                numbers = {n: number for n, number in numbers.items() if number not in held}
            fresh = [name for name in numbers if name not in known]
            taken = {entry.number for entry in entries}
            own = {
                name: numbers[name]
                for name in fresh
                if 1 <= numbers[name] <= GREATEST and numbers[name] not in taken
            }
            others = _next(
                [name for name in fresh if name not in own],
                {name: entry.number for name, entry in known.items()} | own,
            )
            added = [Category(number, name) for name, number in (own | others).items()]
            _check(added)
            _insert(connection, added)
            _write_datasets(
                connection,
                [
                    replace(entry, datasets={dataset: numbers[entry.name]})
                    for entry in (*entries, *added)
                    if entry.name in numbers and dataset not in entry.datasets
                ],
            )

    def put(
        self, wanted: Sequence[Category], attributes: Sequence[BoxAttribute] | None = None
    ) -> list[Category]:
        """Add categories, and give those of known numbers their names and colours.

        Numbers in datasets and sizes are added, or changed; ``attributes`` of boxes take the place
        of those there are, None leaves them.  Raises BadInputError for a number or name out
        of range or given twice, ConflictError for a name that has another number: numbers never
        change; or for a number of a dataset that another category has.
        """
        _check(wanted)
        with self._locked() as connection:
            before = {entry.number: entry for entry in _entries(connection)}
            taken = {entry.name: entry.number for entry in before.values()}
            renamed = {entry.name for entry in before.values()} - {
                before[each.number].name for each in wanted if each.number in before
            }
            for each in wanted:
                if each.name in renamed and taken[each.name] != each.number:
                    raise ConflictError(
                        f"name: expected '{each.name}' to keep its number {taken[each.name]}, "
                        f"got {each.number}"
                    )
            _write(connection, before, wanted)
            _write_datasets(connection, wanted)
            if attributes is not None:
                write_attributes(connection, attributes)
            return _entries(connection)


def _entries(connection: Connection) -> list[Category]:
    columns = categories.c
    query = select(categories).order_by(columns.number)
    datasets: dict[int, dict[str, int]] = {}
    known = dataset_numbers.c
    for dataset, category, number in connection.execute(
        select(known.dataset, known.category, known.number).order_by(known.dataset)
    ):
        datasets.setdefault(int(category), {})[str(dataset)] = int(number)
    return [
        Category(
            row.number,
            row.name,
            row.color,
            datasets.get(row.number, {}),
            _size(row.size),
            _size(row.spread),
        )
        for row in connection.execute(query)
    ]


def _size(told: str | None) -> Size | None:
    if told is None:
        return None
    length, width, height = json.loads(told)
    return length, width, height


def _sizes(each: Category) -> dict[str, str]:
    """Return the columns of the sizes that are given."""
    given = {"size": each.size, "spread": each.spread}
    return {name: json.dumps(size) for name, size in given.items() if size is not None}


def _write_datasets(connection: Connection, wanted: Sequence[Category]) -> None:
    columns = dataset_numbers.c
    for each in wanted:
        for dataset, number in each.datasets.items():
            here = columns.dataset == dataset
            holder = connection.execute(
                select(columns.category).where(here, columns.number == number)
            ).scalar()
            if holder not in (None, each.number):
                raise ConflictError(
                    f"{dataset}: expected number {number} to be that of one category, category "
                    f"{holder} has it, got '{each.name}'"
                )
            connection.execute(delete(dataset_numbers).where(here, columns.category == each.number))
            row = {"dataset": dataset, "category": each.number, "number": number}
            connection.execute(insert(dataset_numbers), row)


def _next(fresh: Sequence[str], known: dict[str, int]) -> dict[str, int]:
    given: dict[str, int] = {}
    highest = max(known.values(), default=0)
    for name in fresh:
        if name in known:
            given[name] = known[name]
            continue
        highest += 1
        if highest > GREATEST:
            raise ConflictError(f"categories: expected at most {GREATEST}, got one more")
        given[name] = highest
    return given


def _check(wanted: Sequence[Category]) -> None:
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


def _write(connection: Connection, before: dict[int, Category], wanted: Sequence[Category]) -> None:
    known = [each for each in wanted if each.number in before]
    # Names may change places: all of them go out of the way first.
    for each in known:
        where = categories.c.number == each.number
        connection.execute(update(categories).where(where).values(name=f"\n{each.number}"))
    for each in known:
        where = categories.c.number == each.number
        values = {"name": each.name, "color": each.color, **_sizes(each)}
        connection.execute(update(categories).where(where).values(**values))
    _insert(connection, [each for each in wanted if each.number not in before])


def _insert(connection: Connection, fresh: Sequence[Category]) -> None:
    if fresh:
        rows = [
            {
                "number": each.number,
                "name": each.name,
                "color": each.color,
                "size": None,
                "spread": None,
                **_sizes(each),
            }
            for each in fresh
        ]
        connection.execute(insert(categories), rows)
