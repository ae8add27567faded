"""Accounts of people and their tokens, for managers."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated

from fastapi import Path, Query
from pydantic import Field

from pointbrush.accounts.accounts import LONGEST_NAME, Token
from pointbrush.accounts.roles import Role
from pointbrush.names import HIDDEN
from pointbrush.web.auth import Caller, resource
from pointbrush.web.context import Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import Body, Out

router = resource("accounts")
AccountName = Annotated[str, Path(max_length=LONGEST_NAME, description="name of an account")]
TokenId = Annotated[str, Query(pattern="^[0-9a-f]{8}$", description="id of one token; else all")]
SHORTEST_DAYS = 1 / 1440
LONGEST_DAYS = 36_500


class TokenBody(Body):
    """A new token; ``role`` null: the account's; ``days`` until it expires, null: never."""

    role: Role | None = None
    days: Annotated[float, Field(ge=SHORTEST_DAYS, le=LONGEST_DAYS)] | None = None


class AccountBody(TokenBody):
    """A new account with its first token."""

    account: Annotated[
        str, Field(min_length=1, max_length=LONGEST_NAME, pattern=f"^[^/{HIDDEN}]+$")
    ]
    role: Role = "annotator"


class TokenOut(Out):
    """A token without its secret; ``role`` is the role that it gives."""

    id: str
    role: Role
    name: str
    created: datetime
    expires: datetime | None
    revoked: datetime | None
    valid: bool


class NewTokenOut(TokenOut):
    """A new token with its secret, ``token``; no other answer contains the secret."""

    account: str
    token: str

    @classmethod
    def made(cls, token: Token, secret: str) -> NewTokenOut:
        """Make the answer of a new token."""
        plain = TokenOut.of(token).model_dump()
        return cls(account=token.account, token=secret, **plain)


class AccountOut(Out):
    """An account with its tokens; ``role`` null: none of them is valid."""

    account: str
    role: Role | None
    tokens: list[TokenOut]


@router.get("/accounts", responses=responses())
def list_accounts(workspace: Ws) -> list[AccountOut]:
    """List the accounts that have or had tokens, by name."""
    return [AccountOut.of(each) for each in workspace.labels.people.all()]


@router.post("/accounts", status_code=201, responses=responses(409, 413))
def create_account(body: AccountBody, workspace: Ws, who: Caller) -> NewTokenOut:
    """Add an account with its first token; the answer contains the secret once.

    No caller gives a role above their own.
    """
    made = workspace.labels.people.create(body.account, body.role, body.days, who.role)
    return NewTokenOut.made(*made)


@router.get("/accounts/{a}/tokens", responses=responses(404))
def list_tokens(a: AccountName, workspace: Ws) -> list[TokenOut]:
    """List the tokens of an account, oldest first, without their secrets."""
    return [TokenOut.of(each) for each in workspace.labels.people.get(a).tokens]


@router.post("/accounts/{a}/tokens", status_code=201, responses=responses(404, 413))
def create_token(a: AccountName, body: TokenBody, workspace: Ws, who: Caller) -> NewTokenOut:
    """Add a token to an account; the answer contains the secret once."""
    made = workspace.labels.people.add_token(a, body.role, body.days, who.role)
    return NewTokenOut.made(*made)


@router.delete("/accounts/{a}/tokens", status_code=204, responses=responses(404))
def revoke_tokens(a: AccountName, workspace: Ws, who: Caller, id: TokenId | None = None) -> None:
    """Revoke all tokens of an account, or one; their sessions end."""
    workspace.labels.people.revoke(a, id, who.role)
