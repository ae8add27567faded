"""Accounts of people and their tokens."""

from __future__ import annotations

from urllib.parse import quote

from pointbrush.client.steps import L, Part, Steps, steps
from pointbrush.values.kinds import Role
from pointbrush.values.team.accounts import Account, NewAccount, NewToken, NewTokenRequest, Token


class Accounts(Part[L]):
    """The accounts of a workspace, for managers; no caller gives a role above their own."""

    @steps
    def all(self) -> Steps[list[Account]]:
        """Return the accounts that have or had tokens, by name."""
        return self._get(list[Account], "/accounts")

    @steps
    def create(
        self, account: str, role: Role = "annotator", days: float | None = None
    ) -> Steps[NewToken]:
        """Add an account with its first token, valid for ``days`` (None: without end).

        Raises ConflictError if the account has a valid token.
        """
        body = NewAccount(account=account, role=role, days=days)
        return self._change(NewToken, "POST", "/accounts", body, idempotent=False)

    @steps
    def tokens(self, account: str) -> Steps[list[Token]]:
        """Return the tokens of an account, oldest first; raises NotFoundError."""
        return self._get(list[Token], _tokens(account))

    @steps
    def add_token(
        self, account: str, role: Role | None = None, days: float | None = None
    ) -> Steps[NewToken]:
        """Add a token to an account (``role`` None: its own role); raises NotFoundError."""
        body = NewTokenRequest(role, days)
        return self._change(NewToken, "POST", _tokens(account), body, idempotent=False)

    @steps
    def revoke(self, account: str, token: str | None = None) -> Steps[None]:
        """Revoke a token of an account by its id (None: all); raises NotFoundError."""
        yield from self._call("DELETE", _tokens(account), params={"id": token}, idempotent=True)


def _tokens(account: str) -> str:
    return f"/accounts/{quote(account, safe='')}/tokens"
