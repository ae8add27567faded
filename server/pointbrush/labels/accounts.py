"""Accounts: who edits are by.  An account's id is what undo goes by; its name is what is shown.

The account of a token has the token's name as its id, and needs no row.  Of those who share the
server's own token each signed-in session has one, ``session:…``, with the name that was chosen.
"""

from __future__ import annotations

import threading
import unicodedata

from sqlalchemy import select

from pointbrush.errors import BadInputError
from pointbrush.labels.database import Database
from pointbrush.labels.schema import accounts
from pointbrush.labels.statements import driver_of, upsert

LONGEST_NAME = 128
OWNER = "owner"
"""The account of the server's own token, where no session and no name tells more."""
RESERVED = frozenset({OWNER, "command line", "import"})
"""Names that are accounts of pointbrush's own; no token has one."""
CONTROL = frozenset({"Cc", "Zl", "Zp"})
BIDIRECTIONAL = frozenset("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
"""Signs that change how what stands behind them is read."""
MARK = ":"
"""In the id of accounts whose name is in the table: no token made now is called so."""

_PUT = upsert(accounts)


class Accounts:
    """The names of one database's accounts; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._names: dict[str, str] = {}
        self._lock = threading.Lock()

    def name(self, account: str) -> str:
        """Return what is shown for an account."""
        if MARK not in account:
            return account
        with self._lock:
            if account in self._names:
                return self._names[account]
        with self._database.read() as connection:
            query = select(accounts.c.name).where(accounts.c.id == account)
            found = connection.execute(query).scalar()
        kind, _, chosen = account.partition(MARK)
        name = str(found) if found is not None else chosen if kind == OWNER else OWNER
        with self._lock:
            self._names[account] = name
        return name

    def rename(self, account: str, name: str) -> None:
        """Give an account without a token the name that was chosen for it."""
        require_name(name)
        if self.name(account) == name:
            return
        with self._database.write() as connection:
            _PUT.run(driver_of(connection), {"id": account, "name": name})
        with self._lock:
            self._names[account] = name


def require_name(name: str) -> None:
    """Raise BadInputError for a name that cannot be shown in a line."""
    if not name.strip() or len(name) > LONGEST_NAME:
        raise BadInputError(f"name: expected 1 to {LONGEST_NAME} characters, got {len(name)}")
    if any(unicodedata.category(sign) in CONTROL or sign in BIDIRECTIONAL for sign in name):
        raise BadInputError("name: expected no control characters")


def require_token_name(name: str) -> None:
    """Raise BadInputError for a name that no token may have."""
    require_name(name)
    plain = name.strip().casefold()
    if plain in RESERVED or plain.startswith("token ") or MARK in name:
        raise BadInputError(
            f"name: expected another one than pointbrush's own ({', '.join(sorted(RESERVED))}) "
            f"and none with a colon, got {name!r}"
        )
