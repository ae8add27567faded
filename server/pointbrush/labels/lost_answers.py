"""Writes whose commit was sent and not answered: they are looked for once the database is back."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

from sqlalchemy import Connection

from pointbrush.errors import UnavailableError
from pointbrush.labels.database import Database
from pointbrush.system import shortages_in_words

SETTLE_SECONDS = 10.0
"""Time in which a lost database must be back for what it may have written to be answered."""
SETTLE_RETRY_SECONDS = 0.1
T = TypeVar("T")


def once_it_is_back(ask: Callable[[], T]) -> T:
    """Ask a lost database until it answers; raises UnavailableError when it does not in time."""
    end = time.monotonic() + SETTLE_SECONDS
    while True:
        try:
            with shortages_in_words():
                return ask()
        except UnavailableError:
            if time.monotonic() > end:
                raise
        time.sleep(SETTLE_RETRY_SECONDS)


def write_once(
    database: Database, make: Callable[[Connection], T], find: Callable[[Connection], T | None]
) -> T:
    """Write what may not be written twice, and return what ``make`` or ``find`` does.

    ``find`` gives what was written, or None, where PostgreSQL was lost before it answered the
    commit.  Raises what ``make`` raises, and UnavailableError.
    """
    sent = False
    try:
        with database.write() as connection:
            made = make(connection)
            sent = True
        return made
    except UnavailableError:
        if database.sqlite or not sent:
            raise

        def look() -> T | None:
            with database.read() as connection:
                return find(connection)

        found = once_it_is_back(look)
        if found is None:
            raise
        return found
