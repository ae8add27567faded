"""Accounts of people, and their tokens."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from pointbrush.values.base import Body, Rule, Value
from pointbrush.values.kinds import HIDDEN, Role

LONGEST_NAME = 128
"""Longest name of an account, characters."""
SHORTEST_DAYS, LONGEST_DAYS = 1 / 1440, 36_500
Days = Annotated[float, Rule(ge=SHORTEST_DAYS, le=LONGEST_DAYS)]


@dataclass(frozen=True, slots=True)
class NewTokenRequest(Body):
    """A token to create."""

    role: Role | None = None
    """Role that it gives; null: the account's role."""
    days: Days | None = None
    """Days until it expires; null: never."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NewAccount(NewTokenRequest):
    """A new account with its first token."""

    account: Annotated[str, Rule(min_length=1, max_length=LONGEST_NAME, pattern=f"^[^/{HIDDEN}]+$")]
    """Name of the account, which edits show."""
    role: Role = "annotator"
    """Role that its token gives."""


@dataclass(frozen=True, slots=True)
class Token(Value):
    """A token without its secret."""

    id: str
    """Id for its revocation."""
    role: Role
    """Role that it gives."""
    name: str
    """Name of the account."""
    created: datetime
    """Time of its creation."""
    expires: datetime | None
    """End of its validity; null: never."""
    revoked: datetime | None
    """Time of its revocation; null: not revoked."""
    valid: bool
    """It gives access now."""


@dataclass(frozen=True, slots=True)
class AccountToken(Token):
    """A token without its secret, and its account."""

    account: str
    """Id of the account, which is the author of its edits."""


@dataclass(frozen=True, slots=True)
class NewToken(AccountToken):
    """A new token with its secret; no other answer contains the secret."""

    token: str
    """The secret."""


@dataclass(frozen=True, slots=True)
class Account(Value):
    """An account with its tokens."""

    account: str
    """Name of the account."""
    role: Role | None
    """Highest role of its valid tokens; null: none is valid."""
    tokens: tuple[Token, ...]
    """Its tokens, oldest first."""
