"""The account of each browser that shares the server's own token, kept in a signed cookie.

The cookie lets nobody in: it only tells who signs in with the server's own token, once that has
been checked.  It outlives sessions, sign-outs and the token, so that undo still finds the edits.
"""

from __future__ import annotations

import hmac
import secrets

from starlette.requests import HTTPConnection

from pointbrush.labels.signing_keys import SigningKeys
from pointbrush.web.cookies import Cookie

PURPOSE = "browser account"
DAYS = 400
"""The longest that browsers keep a cookie; each sign-in begins them anew."""
MARK_BYTES = 4
PREFIX = "pointbrush_account_"
MOST_COOKIES = 8
"""Accounts of a browser on one host, each of another database; a cookie has 120 bytes."""


class BrowserAccounts:
    """Makes, signs and checks the accounts of browsers; thread-safe."""

    def __init__(self, keys: SigningKeys) -> None:
        self._keys = keys

    def read(self, connection: HTTPConnection) -> str | None:
        """Return the account that the browser brings, or None where it brings no valid one."""
        value = connection.cookies.get(self._name(connection), "")
        account, _, signature = value.rpartition(".")
        right = self._signature(account)
        return account if hmac.compare_digest(signature.encode(), right.encode()) else None

    def cookies(self, connection: HTTPConnection, account: str) -> list[Cookie]:
        """Return the cookie by which the browser keeps ``account``, and those that it is to drop.

        Every server of the host is sent all cookies: the oldest of other databases go.
        """
        mine = self._name(connection)
        others = [name for name in connection.cookies if name.startswith(PREFIX) and name != mine]
        dropped = [Cookie(name, "", 0) for name in others[: -(MOST_COOKIES - 1)]]
        return [Cookie(mine, f"{account}.{self._signature(account)}", DAYS), *dropped]

    def _name(self, connection: HTTPConnection) -> str:
        """Name the cookie by the key: browsers send cookies to every port of a host.

        Servers with databases of their own leave each other's alone, also one after the other
        on one port; two on one database share it.  Encrypted and plain ones differ, since a
        browser does not let a plain answer replace an encrypted one's.
        """
        mark = hmac.digest(self._keys.get(PURPOSE), b"name", "sha256")[:MARK_BYTES].hex()
        return f"{PREFIX}{'https' if connection.url.is_secure else 'http'}_{mark}"

    def _signature(self, account: str) -> str:
        message = f"account {account}".encode("utf-8", "surrogateescape")
        return hmac.digest(self._keys.get(PURPOSE), message, "sha256").hex()


def new_account() -> str:
    """Return the id of a new account, which nobody can guess."""
    return f"browser:{secrets.token_hex(16)}"
