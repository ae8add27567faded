"""Writes with an unanswered commit: they are looked up when the database is available again."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

from sqlalchemy import Connection

from pointbrush.database.database import Database
from pointbrush.errors import UnavailableError
from pointbrush.system.resources import shortages_as_unavailable

SETTLE_SECONDS = 10.0
"""Longest wait for a lost database until the result of a write can be looked up."""
SETTLE_RETRY_SECONDS = 0.1
T = TypeVar("T")


def once_it_is_back(ask: Callable[[], T]) -> T:
    """Query a lost database until it answers; raises UnavailableError after SETTLE_SECONDS."""
    end = time.monotonic() + SETTLE_SECONDS
    while True:
        try:
            with shortages_as_unavailable():
                return ask()
        except UnavailableError:
            if time.monotonic() > end:
                raise
        time.sleep(SETTLE_RETRY_SECONDS)


def write_once(
    database: Database, make: Callable[[Connection], T], find: Callable[[Connection], T | None]
) -> T:
    """Write exactly once and return the result of ``make`` or ``find``.

    If PostgreSQL is lost before it answers the commit, ``find`` returns the written result, or
    None.  Raises the errors of ``make``, and UnavailableError.
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
