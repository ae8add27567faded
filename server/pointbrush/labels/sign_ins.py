"""Sign-ins of the page: a random id in its cookie, of which only the digest is kept."""

from __future__ import annotations

import secrets
import time
from dataclasses import dataclass

from sqlalchemy import and_, delete, insert, select

from pointbrush.labels.database import Database
from pointbrush.labels.schema import sign_ins, tokens
from pointbrush.labels.tokens import Token, digest_of, token_of


@dataclass(frozen=True, slots=True)
class SignIn:
    """Identity behind a cookie: a person's ``token``, or the server's own (None).

    ``account`` is the one that its edits are by; ``owner`` is the digest of the server's own token
    that it was made with, or "".
    """

    account: str
    token: Token | None
    owner: str


class SignIns:
    """The sign-ins of one database."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(self, account: str, token: str | None, owner: str, expires: float) -> str:
        """Make a sign-in and return its id for the cookie.

        ``token``: a token's id; ``owner``: the digest of the server's own; ``expires``: seconds
        since the epoch.  Those that have expired go.
        """
        secret = secrets.token_urlsafe(32)
        row = {
            "digest": digest_of(secret), "token": token, "owner": owner, "account": account,
            "created": time.time(), "expires": expires,
        }  # fmt: skip
        with self._database.write() as connection:
            connection.execute(delete(sign_ins).where(sign_ins.c.expires < time.time()))
            connection.execute(insert(sign_ins), row)
        return secret

    def check(self, secret: str) -> SignIn | None:
        """Return what a cookie stands for, or None once it, or its token, lets nobody in."""
        joined = sign_ins.outerjoin(tokens, tokens.c.id == sign_ins.c.token)
        chosen = (sign_ins.c.account, sign_ins.c.owner, sign_ins.c.token.label("of"), tokens)
        valid = and_(sign_ins.c.digest == digest_of(secret), sign_ins.c.expires > time.time())
        with self._database.read() as connection:
            row = connection.execute(select(*chosen).select_from(joined).where(valid)).one_or_none()
        if row is None:
            return None
        if row.of is None:
            return SignIn(row.account, None, row.owner)
        token = None if row.id is None else token_of(row)
        return SignIn(row.account, token, "") if token is not None and token.valid else None

    def end(self, secret: str) -> None:
        """End a sign-in; an unknown one is no error."""
        with self._database.write() as connection:
            connection.execute(delete(sign_ins).where(sign_ins.c.digest == digest_of(secret)))
