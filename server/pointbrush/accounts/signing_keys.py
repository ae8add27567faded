"""Secret keys for signed cookies of clients, shared by all servers of one database."""

from __future__ import annotations

import secrets
import threading

from sqlalchemy import select

from pointbrush.database.database import Database
from pointbrush.database.schema import signing_keys
from pointbrush.database.statements import insert
from pointbrush.errors import ReadOnlyError

KEY_BYTES = 32


class SigningKeys:
    """The keys of one database, each made at its first use; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._known: dict[str, bytes] = {}
        self._lock = threading.Lock()

    def get(self, purpose: str) -> bytes:
        """Return the key (32 random bytes) of ``purpose``, the same for every server.

        For a read-only database without a key, the key is valid for the lifetime of this object.
        Raises UnavailableError.
        """
        with self._lock:
            key = self._known.get(purpose)
            if key is None:
                key = self._known[purpose] = self._stored(purpose) or self._made(purpose)
            return key

    def _stored(self, purpose: str) -> bytes | None:
        wanted = select(signing_keys.c.key).where(signing_keys.c.purpose == purpose)
        with self._database.read() as connection:
            found = connection.execute(wanted).scalar()
        return None if found is None else bytes(found)

    def _made(self, purpose: str) -> bytes:
        key = secrets.token_bytes(KEY_BYTES)
        new = insert(signing_keys, sqlite=self._database.sqlite).on_conflict_do_nothing()
        try:
            with self._database.write() as connection:
                connection.execute(new, {"purpose": purpose, "key": key})
        except ReadOnlyError:
            return key
        # Another server may have stored a key first.
        return self._stored(purpose) or key
