"""Accounts of people and their tokens, for managers."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path, Query

from pointbrush.values.team.accounts import (
    LONGEST_NAME,
    Account,
    NewAccount,
    NewToken,
    NewTokenRequest,
    Token,
)
from pointbrush.web.context import Ws
from pointbrush.web.security.auth import Caller, resource
from pointbrush.web.security.roles import needs

router = resource("accounts")
AccountName = Annotated[str, Path(max_length=LONGEST_NAME, description="name of an account")]
TokenId = Annotated[str, Query(pattern="^[0-9a-f]{8}$", description="id of one token; else all")]


@router.get("/accounts", **needs("manager"))
def list_accounts(workspace: Ws) -> list[Account]:
    """List the accounts that have or had tokens, by name."""
    return workspace.labels.people.all()


@router.post("/accounts", status_code=201, **needs("manager", 409, 413))
def create_account(body: NewAccount, workspace: Ws, who: Caller) -> NewToken:
    """Add an account with its first token; the answer contains the secret once.

    No caller gives a role above their own.
    """
    return workspace.labels.people.create(body.account, body.role, body.days, who.role)


@router.get("/accounts/{a}/tokens", **needs("manager", 404))
def list_tokens(a: AccountName, workspace: Ws) -> list[Token]:
    """List the tokens of an account, oldest first, without their secrets."""
    return list(workspace.labels.people.get(a).tokens)


@router.post("/accounts/{a}/tokens", status_code=201, **needs("manager", 404, 413))
def create_token(a: AccountName, body: NewTokenRequest, workspace: Ws, who: Caller) -> NewToken:
    """Add a token to an account; the answer contains the secret once."""
    return workspace.labels.people.add_token(a, body.role, body.days, who.role)


@router.delete("/accounts/{a}/tokens", status_code=204, **needs("manager", 404))
def revoke_tokens(
    a: AccountName,
    workspace: Ws,
    who: Caller,
    id: Annotated[TokenId | None, Query(description="id of one token; else all")] = None,
) -> None:
    """Revoke all tokens of an account, or one; their sessions end."""
    workspace.labels.people.revoke(a, id, who.role)
