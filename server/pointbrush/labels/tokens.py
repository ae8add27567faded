"""Access tokens: a random secret and a role.

Only the SHA-256 of a secret is stored.  A slow password hash would add nothing: the secret is
256 random bits, which nobody can guess from its digest at any speed; and every request pays
for the check.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
import time
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Row, bindparam, insert, select, update

from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.labels.accounts import require_token_name
from pointbrush.labels.database import Database
from pointbrush.labels.schema import tokens
from pointbrush.labels.statements import Statement
from pointbrush.roles import ROLES, Role


@dataclass(frozen=True, slots=True)
class Token:
    """Record of a token; times are seconds since the epoch, None: never."""

    id: str
    role: Role
    name: str
    created: float
    expires: float | None
    revoked: float | None
    account: str
    """The account that its edits are by."""

    @property
    def valid(self) -> bool:
        """Whether it lets somebody in now."""
        return self.revoked is None and (self.expires is None or time.time() < self.expires)


class Tokens:
    """The tokens of one database."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(self, role: str, name: str = "", expires: float | None = None) -> str:
        """Make a token and return its secret, which is shown this once.

        ``name`` is whom it is for; without one the token is an account of its own.  ``expires``:
        seconds since the epoch.  Raises BadInputError for an unknown role or a name that no token
        may have, ConflictError for the name of a valid token.
        """
        if role not in ROLES:
            raise BadInputError(f"role: expected one of {', '.join(ROLES)}, got {role!r}")
        if name:
            require_token_name(name)
        secret = secrets.token_urlsafe(32)
        number = secrets.token_hex(4)
        row = {
            "id": number,
            "account": name or f"token {number}",
            "role": role,
            "name": name,
            "digest": digest_of(secret),
            "created": time.time(),
            "expires": expires,
        }
        with self._database.write() as connection:
            if name:
                same = connection.execute(select(tokens).where(tokens.c.name == name)).all()
                if any(token_of(other).valid for other in same):
                    raise ConflictError(
                        f"name: expected one that no valid token has, got {name!r}; revoke it first"
                    )
            connection.execute(insert(tokens), row)
        return secret

    def list(self) -> list[Token]:
        """All tokens, oldest first, revoked and expired ones too."""
        with self._database.read() as connection:
            rows = connection.execute(select(tokens).order_by(tokens.c.created)).all()
        return [token_of(row) for row in rows]

    def revoke(self, token_id: str) -> Token:
        """End a token's validity now; raises NotFoundError for an unknown id."""
        with self._database.write() as connection:
            here = tokens.c.id == token_id
            row = connection.execute(select(tokens).where(here)).one_or_none()
            if row is None:
                raise NotFoundError(f"token: expected the id of a token, got {token_id!r}")
            if row.revoked is None:
                connection.execute(update(tokens).where(here).values(revoked=time.time()))
            return token_of(connection.execute(select(tokens).where(here)).one())

    def check(self, secret: str) -> Token | None:
        """The valid token with this secret, or None."""
        digest = digest_of(secret)
        row = self._database.look(_OF_DIGEST, {"digest": digest})
        # The look-up compares digests, from whose timing no secret can be built; the comparison
        # that decides is constant in time all the same.
        if row is None or not hmac.compare_digest(row.digest.encode(), digest.encode()):
            return None
        token = token_of(row)
        return token if token.valid else None


_OF_DIGEST = Statement(select(tokens).where(tokens.c.digest == bindparam("digest")))


def digest_of(secret: str) -> str:
    """Return what is kept of a secret."""
    return hashlib.sha256(secret.encode("utf-8", "surrogateescape")).hexdigest()


def token_of(row: Row[Any]) -> Token:
    """Return what a row says."""
    return Token(row.id, row.role, row.name, row.created, row.expires, row.revoked, row.account)
