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

    def cookie(self, connection: HTTPConnection, account: str) -> Cookie:
        """Return the cookie by which the browser keeps ``account``."""
        return Cookie(self._name(connection), f"{account}.{self._signature(account)}", DAYS)

    def _name(self, connection: HTTPConnection) -> str:
        """Name the cookie by the key: browsers send cookies to every port of a host.

        Servers with databases of their own leave each other's alone, also one after the other
        on one port; two on one database share it.  Encrypted and plain ones differ, since a
        browser does not let a plain answer replace an encrypted one's.
        """
        mark = hmac.digest(self._keys.get(PURPOSE), b"name", "sha256")[:MARK_BYTES].hex()
        return f"pointbrush_account_{'https' if connection.url.is_secure else 'http'}_{mark}"

    def _signature(self, account: str) -> str:
        message = f"account {account}".encode("utf-8", "surrogateescape")
        return hmac.digest(self._keys.get(PURPOSE), message, "sha256").hex()


def new_account() -> str:
    """Return the id of a new account, which nobody can guess."""
    return f"browser:{secrets.token_hex(16)}"
