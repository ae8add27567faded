"""Keyboard shortcuts of the page's commands that an account has set, for all its browsers."""

from __future__ import annotations

import json
from collections.abc import Mapping

from sqlalchemy import select

from pointbrush.database.database import Database
from pointbrush.database.schema import own_keys
from pointbrush.database.statements import driver_of, upsert

_PUT = upsert(own_keys)


class OwnKeys:
    """The keyboard shortcuts of one database's accounts; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def get(self, account: str) -> dict[str, str] | None:
        """Return an account's keys by command; None if it has not set any.

        Raises UnavailableError.
        """
        wanted = select(own_keys.c["keys"]).where(own_keys.c.account == account)
        with self._database.read() as connection:
            found = connection.execute(wanted).scalar()
        return None if found is None else dict(json.loads(found))

    def put(self, account: str, keys: Mapping[str, str]) -> None:
        """Store an account's keys by command, replacing all earlier ones.

        Raises ReadOnlyError and UnavailableError.
        """
        row = {"account": account, "keys": json.dumps(dict(keys), ensure_ascii=False)}
        with self._database.write() as connection:
            _PUT.run(driver_of(connection), row)
