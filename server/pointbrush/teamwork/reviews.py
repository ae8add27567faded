"""The log of reviews: decisions about frames or a label, in chronological order."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, func, insert, select

from pointbrush.database.database import Database
from pointbrush.database.lost_answers import write_once
from pointbrush.database.schema import LIVE, reviews, sequences
from pointbrush.errors import NotFoundError

Place = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Review:
    """A line of the log.

    ``first``, ``last``  the reviewed frames, both included; None: the label as a whole.
    ``label``            the reviewed label, or 0: the frames themselves.
    ``state``, ``note``, ``assignee``  values to set; None keeps, "" removes a note or a person.
    ``place``            position of the note in source coordinates, metres, or None.
    ``number``, ``time``, ``author``, ``revision``  set when it is added: its number in the log,
    seconds since the epoch, an account, the reviewed revision of the sequence.
    """

    first: int | None
    last: int | None
    label: int = 0
    state: str | None = None
    note: str | None = None
    place: Place | None = None
    assignee: str | None = None
    number: int = 0
    time: float = 0.0
    author: str = ""
    revision: int = 0


class Reviews:
    """The reviews of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(
        self,
        sequence: str,
        identity: str,
        author: str,
        review: Review,
        require: Callable[[Sequence[Review]], object] | None = None,
    ) -> Review:
        """Append a review to the log and return it once it is durable.

        ``identity``: of the reviewed import.  ``require`` checks the locked log before the review
        is appended, and raises an error to refuse it.  Raises NotFoundError if another import has
        the id now, UnavailableError, ReadOnlyError.
        """

        def make(connection: Connection) -> Review:
            row = _sequence(connection, sequence, lock=True)
            if row.identity not in (None, identity):
                raise NotFoundError(f"sequence: {sequence!r} was imported again meanwhile")
            if require is not None:
                require(_entries(connection, row.number))
            last = select(func.max(reviews.c.number)).where(reviews.c.sequence == row.number)
            values = {
                "number": (connection.execute(last).scalar() or 0) + 1,
                "time": self._database.now(connection),
                "author": author,
                "revision": row.revision,
                "first": review.first,
                "last": review.last,
                "label": review.label,
                "state": review.state,
                "note": review.note,
                "place": None if review.place is None else json.dumps(review.place),
                "assignee": review.assignee,
            }
            connection.execute(insert(reviews), {"sequence": row.number, **values})
            made.append(Review(**{**values, "place": review.place}))
            return made[-1]

        def find(connection: Connection) -> Review | None:
            number = _sequence(connection, sequence).number
            return next((one for one in _entries(connection, number) if one == made[-1]), None)

        made: list[Review] = []
        return write_once(self._database, make, find)

    def entries(self, sequence: str) -> list[Review]:
        """Return the whole log, oldest first; raises NotFoundError."""
        with self._database.read() as connection:
            return _entries(connection, _sequence(connection, sequence).number)


def _entries(connection: Connection, number: int) -> list[Review]:
    query = select(reviews).where(reviews.c.sequence == number).order_by(reviews.c.number)
    return [_review(row) for row in connection.execute(query)]


def _sequence(connection: Connection, sequence: str, *, lock: bool = False) -> Row[Any]:
    query = select(sequences).where(sequences.c.id == sequence, LIVE)
    row = connection.execute(query.with_for_update() if lock else query).one_or_none()
    if row is None:
        raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
    return row


def _review(row: Row[Any]) -> Review:
    values = {name: value for name, value in row._mapping.items() if name != "sequence"}
    place = values["place"]
    return Review(**{**values, "place": None if place is None else tuple(json.loads(place))})
