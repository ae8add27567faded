"""Accounts of people and their tokens."""

from __future__ import annotations

from typing import Any
from urllib.parse import quote

from pointbrush.client.answers import read
from pointbrush.client.steps import L, Part, Request, Steps, send, steps
from pointbrush.values.kinds import Role
from pointbrush.values.team.accounts import Account, NewAccount, NewToken, NewTokenRequest, Token


class Accounts(Part[L]):
    """The accounts of a workspace, for managers; no caller gives a role above their own."""

    @steps
    def all(self) -> Steps[list[Account]]:
        """Return the accounts that have or had tokens, by name."""
        answer = yield from send(Request("GET", "/accounts", idempotent=True))
        return [read(Account, entry) for entry in answer.json()]

    @steps
    def create(
        self, account: str, role: Role = "annotator", days: float | None = None
    ) -> Steps[NewToken]:
        """Add an account with its first token, valid for ``days`` (None: without end).

        Raises ConflictError if the account has a valid token.
        """
        body = NewAccount(account=account, role=role, days=days).given()
        return (yield from _made(Request("POST", "/accounts", {"json": body})))

    @steps
    def tokens(self, account: str) -> Steps[list[Token]]:
        """Return the tokens of an account, oldest first; raises NotFoundError."""
        answer = yield from send(Request("GET", _tokens(account), idempotent=True))
        return [read(Token, entry) for entry in answer.json()]

    @steps
    def add_token(
        self, account: str, role: Role | None = None, days: float | None = None
    ) -> Steps[NewToken]:
        """Add a token to an account (``role`` None: its own role); raises NotFoundError."""
        body = NewTokenRequest(role, days).given()
        return (yield from _made(Request("POST", _tokens(account), {"json": body})))

    @steps
    def revoke(self, account: str, token: str | None = None) -> Steps[None]:
        """Revoke a token of an account by its id (None: all); raises NotFoundError."""
        query: dict[str, Any] = {} if token is None else {"params": {"id": token}}
        yield from send(Request("DELETE", _tokens(account), query, idempotent=True))


def _tokens(account: str) -> str:
    return f"/accounts/{quote(account, safe='')}/tokens"


def _made(request: Request) -> Steps[NewToken]:
    answer = yield from send(request)
    return read(NewToken, answer.json())
