"""Accounts of people and their tokens."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Any
from urllib.parse import quote

from pointbrush.client.steps import L, Part, Request, Steps, send, steps
from pointbrush.client.values import read


@dataclass(frozen=True, slots=True)
class Token:
    """A token without its secret; ``expires`` and ``revoked`` None: never."""

    id: str
    role: str
    name: str
    created: datetime
    expires: datetime | None
    revoked: datetime | None
    valid: bool


@dataclass(frozen=True, slots=True)
class NewToken:
    """A new token of an account: its id, role and secret ``token``, which is shown once."""

    account: str
    id: str
    role: str
    token: str


@dataclass(frozen=True, slots=True)
class Account:
    """An account with its tokens; ``role`` None: none of them is valid."""

    account: str
    role: str | None
    tokens: tuple[Token, ...]


class Accounts(Part[L]):
    """The accounts of a workspace, for managers; no caller gives a role above their own."""

    @steps
    def all(self) -> Steps[list[Account]]:
        """Return the accounts that have or had tokens, by name."""
        answer = yield from send(Request("GET", "/accounts", again=True))
        return [read(Account, entry) for entry in answer.json()]

    @steps
    def create(
        self, account: str, role: str = "annotator", days: float | None = None
    ) -> Steps[NewToken]:
        """Add an account with its first token, valid for ``days`` (None: without end).

        Raises ConflictError if the account has a valid token.
        """
        body = {"account": account, "role": role, "days": days}
        return (yield from _made(Request("POST", "/accounts", {"json": body})))

    @steps
    def tokens(self, account: str) -> Steps[list[Token]]:
        """Return the tokens of an account, oldest first; raises NotFoundError."""
        answer = yield from send(Request("GET", _tokens(account), again=True))
        return [read(Token, entry) for entry in answer.json()]

    @steps
    def add_token(
        self, account: str, role: str | None = None, days: float | None = None
    ) -> Steps[NewToken]:
        """Add a token to an account (``role`` None: its own role); raises NotFoundError."""
        body = {"role": role, "days": days}
        return (yield from _made(Request("POST", _tokens(account), {"json": body})))

    @steps
    def revoke(self, account: str, token: str | None = None) -> Steps[None]:
        """Revoke a token of an account by its id (None: all); raises NotFoundError."""
        query: dict[str, Any] = {} if token is None else {"params": {"id": token}}
        yield from send(Request("DELETE", _tokens(account), query, again=True))


def _tokens(account: str) -> str:
    return f"/accounts/{quote(account, safe='')}/tokens"


def _made(request: Request) -> Steps[NewToken]:
    answer = yield from send(request)
    return read(NewToken, answer.json())
