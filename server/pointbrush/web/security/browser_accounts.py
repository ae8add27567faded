"""The account of each browser that shares the server's own token, kept in a signed cookie.

The cookie gives no access: it only identifies the browser that signs in with the server's own
token.  It outlives sessions, sign-outs and the token, so that undo still finds the edits.
"""

from __future__ import annotations

import hmac
import secrets

from starlette.requests import HTTPConnection

from pointbrush.accounts.signing_keys import SigningKeys
from pointbrush.web.security.cookies import Cookie

PURPOSE = "browser account"
DAYS = 400
"""Longest time that browsers keep a cookie; each sign-in renews it."""
MARK_BYTES = 4
PREFIX = "pointbrush_account_"
MOST_COOKIES = 8
"""Most accounts of a browser on one host, one for each database; a cookie has 120 bytes."""


class BrowserAccounts:
    """Makes, signs and checks the accounts of browsers; thread-safe."""

    def __init__(self, keys: SigningKeys) -> None:
        self._keys = keys

    def read(self, connection: HTTPConnection) -> str | None:
        """Return the account in the browser's cookie, or None without a valid cookie."""
        value = connection.cookies.get(self._name(connection), "")
        account, _, signature = value.rpartition(".")
        right = self._signature(account)
        return account if hmac.compare_digest(signature.encode(), right.encode()) else None

    def cookies(self, connection: HTTPConnection, account: str) -> list[Cookie]:
        """Return the cookie that stores ``account``, and cookies that the browser must drop.

        Browsers send all cookies to every server of a host: the oldest of other databases go.
        """
        mine = self._name(connection)
        others = [name for name in connection.cookies if name.startswith(PREFIX) and name != mine]
        dropped = [Cookie(name, "", 0) for name in others[: -(MOST_COOKIES - 1)]]
        return [Cookie(mine, f"{account}.{self._signature(account)}", DAYS), *dropped]

    def _name(self, connection: HTTPConnection) -> str:
        """Return the cookie's name, derived from the key: browsers send cookies to every port.

        Servers with different databases have different cookies, even one after the other on one
        port; servers on one database share one.  HTTPS and HTTP have different names, because
        browsers do not let an HTTP answer replace a cookie of HTTPS.
        """
        mark = hmac.digest(self._keys.get(PURPOSE), b"name", "sha256")[:MARK_BYTES].hex()
        return f"{PREFIX}{'https' if connection.url.is_secure else 'http'}_{mark}"

    def _signature(self, account: str) -> str:
        message = f"account {account}".encode("utf-8", "surrogateescape")
        return hmac.digest(self._keys.get(PURPOSE), message, "sha256").hex()


def new_account() -> str:
    """Return the id of a new account, which cannot be guessed."""
    return f"browser:{secrets.token_hex(16)}"
