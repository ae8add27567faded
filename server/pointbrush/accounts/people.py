"""People with access to a workspace: their accounts, roles and tokens, as managers see them."""

from __future__ import annotations

import time

from pointbrush.accounts.accounts import Tokens
from pointbrush.accounts.roles import ROLES, Role, require, require_known
from pointbrush.errors import NotFoundError
from pointbrush.values.team.accounts import Account, NewToken, Token

DAY = 86_400.0
"""Seconds."""


class People:
    """The accounts of one database that have, or had, tokens.

    ``by`` is the role of the caller, the highest role that they can assign or revoke.
    """

    def __init__(self, tokens: Tokens) -> None:
        self._tokens = tokens

    def all(self) -> list[Account]:
        """Return all accounts by name, including accounts without a valid token."""
        found: dict[str, list[Token]] = {}
        for token in self._tokens.list():
            found.setdefault(token.account, []).append(token)
        return [_account(name, tuple(found[name])) for name in sorted(found, key=str.casefold)]

    def get(self, account: str) -> Account:
        """Return an account; raises NotFoundError."""
        for each in self.all():
            if each.account == account:
                return each
        raise NotFoundError(f"account: expected the name of an account, got {account!r}")

    def create(self, account: str, role: Role, days: float | None, by: Role) -> NewToken:
        """Create an account with its first token, and return the token.

        Raises BadInputError for an unknown role or an invalid name, ConflictError if the account
        has a valid token, ForbiddenError.
        """
        require_known(role)
        require(by, role)
        return self._added(self._tokens.add(role, account, expiry_of(days)))

    def add_token(self, account: str, role: Role | None, days: float | None, by: Role) -> NewToken:
        """Create another token of an account and return it.

        ``role`` None: the account's role, or else the role of its last token.  Raises
        NotFoundError, ForbiddenError.
        """
        known = self.get(account)
        role = role or known.role or known.tokens[-1].role
        require(by, max(role, known.role or role, key=ROLES.index))
        return self._added(self._tokens.add(role, account, expiry_of(days), another=True))

    def revoke(self, account: str, token: str | None, by: Role) -> None:
        """Revoke a token of an account, or (None) all; raises NotFoundError, ForbiddenError."""
        known = self.get(account).tokens
        ended = [each for each in known if token in (None, each.id)]
        if not ended:
            raise NotFoundError(f"token: expected the id of a token of {account!r}, got {token!r}")
        for each in ended:
            require(by, each.role)
        for each in ended:
            self._tokens.revoke(each.id)

    def _added(self, secret: str) -> NewToken:
        made = self._tokens.check(secret)
        if made is None:
            raise NotFoundError("token: expected the new token, it was revoked at once")
        return NewToken.of(made, token=secret)


def _account(name: str, tokens: tuple[Token, ...]) -> Account:
    """Return an account with its tokens and its current role."""
    role = max((t.role for t in tokens if t.valid), key=ROLES.index, default=None)
    return Account(name, role, tokens)


def expiry_of(days: float | None) -> float | None:
    """Return the time in some days, seconds since the epoch; None: never."""
    return None if days is None else time.time() + days * DAY
