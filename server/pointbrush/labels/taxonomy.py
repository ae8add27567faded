"""The classes of a workspace: a category has one number in all recordings, for ever."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sqlalchemy import insert, select, update
from sqlalchemy.engine import Connection
from sqlalchemy.exc import IntegrityError

from pointbrush.errors import BadInputError, ConflictError, ReadOnlyError
from pointbrush.labels.database import Database
from pointbrush.labels.schema import categories

GREATEST = 65535
"""Greatest number of a category: SemanticKITTI keeps it in 16 bits."""
LONGEST = 256
"""Characters of a name."""
TRIES = 3
"""Times that numbers are given out, should another server give the same ones out meanwhile."""


@dataclass(frozen=True, slots=True)
class Category:
    """A class: ``number`` 1..65535, ``name``, ``color`` ``#rrggbb`` or ""."""

    number: int
    name: str
    color: str = ""


class Taxonomy:
    """The categories of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def entries(self) -> list[Category]:
        """Return all categories, by number."""
        with self._database.read() as connection:
            return _entries(connection)

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
        for left in range(TRIES, 0, -1):
            try:
                with self._database.write() as connection:
                    known = {entry.name: entry.number for entry in _entries(connection)}
                    given = _next(fresh, known)
                    rows = [
                        {"number": number, "name": name, "color": ""}
                        for name, number in given.items()
                        if name not in known
                    ]
                    if rows:
                        connection.execute(insert(categories), rows)
                    return given
            except ReadOnlyError:
                break
            except IntegrityError:
                if left == 1:
                    raise
        return _next(fresh, known)

    def put(self, wanted: Sequence[Category]) -> list[Category]:
        """Add categories, and give those of known numbers their names and colours.

        Raises BadInputError for a number or name out of range or given twice, ConflictError for a
        name that has another number: numbers never change.
        """
        _check(wanted)
        with self._database.write() as connection:
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
            return _entries(connection)


def _entries(connection: Connection) -> list[Category]:
    columns = categories.c
    query = select(columns.number, columns.name, columns.color).order_by(columns.number)
    return [Category(int(n), str(name), str(color)) for n, name, color in connection.execute(query)]


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
        values = {"name": each.name, "color": each.color}
        connection.execute(update(categories).where(where).values(**values))
    fresh = [
        {"number": each.number, "name": each.name, "color": each.color}
        for each in wanted
        if each.number not in before
    ]
    if fresh:
        connection.execute(insert(categories), fresh)
