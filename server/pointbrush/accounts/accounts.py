"""Accounts, the tokens that open them, and sign-ins of the page.

Undo works per account id; the page shows the account's name.  The account of a token has the
token's name as its id, and needs no row.  Each browser that uses the server's own token has an
account ``browser:…`` with a chosen name (``session:…`` if it was made by an older version).

A token is a random secret and a role.  Only the SHA-256 of the secret, and of the random id in a
sign-in's cookie, is stored.  A slow password hash would not add security, as a secret of 256 random
bits cannot be guessed from its digest, and every request would pay for it.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
import threading
import time
from collections.abc import Container, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, and_, bindparam, delete, insert, select, update

from pointbrush.accounts.roles import Role, require_known
from pointbrush.database.database import Database
from pointbrush.database.lost_answers import write_once
from pointbrush.database.schema import accounts, sign_ins, tokens
from pointbrush.database.statements import Statement, driver_of, upsert
from pointbrush.database.statements import insert as insert_new
from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.names import require_visible
from pointbrush.values.kinds import time_of
from pointbrush.values.team.accounts import LONGEST_NAME, AccountToken

OWNER = "owner"
"""The account of scripts that send the server's own token."""
RESERVED = frozenset({OWNER, "command line", "import"})
"""Names of built-in accounts; no token may have one."""
ELSEWHERE = "elsewhere:"
"""Prefix of the digest of a token without a secret; no hexadecimal digest has these letters."""
PARTICIPANT = "participant"
"""Name of all participants of studies; their accounts are it, ``MARK`` and a random text."""
MARK = ":"
"""Separator in the id of an account with a name in the table; new tokens cannot have it."""

_PUT = upsert(accounts)


class Accounts:
    """The names of one database's accounts; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._names: dict[str, str] = {}
        self._lock = threading.Lock()

    def known(self, account: str) -> str | None:
        """Return the name of an account without a query; None: the database has to be queried."""
        if MARK not in account:
            return account
        with self._lock:
            return self._names.get(account)

    def name(self, account: str) -> str:
        """Return the name shown for an account; raises UnavailableError."""
        known = self.known(account)
        if known is not None:
            return known
        with self._database.read() as connection:
            query = select(accounts.c.name).where(accounts.c.id == account)
            found = connection.execute(query).scalar()
        kind, _, chosen = account.partition(MARK)
        own = {OWNER: chosen, PARTICIPANT: PARTICIPANT}
        name = str(found) if found is not None else own.get(kind, OWNER)
        with self._lock:
            self._names[account] = name
        return name

    def rename(self, account: str, name: str) -> None:
        """Set the chosen name of an account without a token."""
        require_name(name)
        if self.name(account) == name:
            return
        with self._database.write() as connection:
            _PUT.run(driver_of(connection), {"id": account, "name": name})
        with self._lock:
            self._names[account] = name


def require_name(name: str) -> None:
    """Raise BadInputError for a name that cannot be shown in a line."""
    if not name.strip() or len(name) > LONGEST_NAME:
        raise BadInputError(f"name: expected 1 to {LONGEST_NAME} characters, got {len(name)}")
    require_visible("name", name)


def require_token_name(name: str) -> None:
    """Raise BadInputError for a name that no token may have."""
    require_name(name)
    plain = name.strip().casefold()
    if plain in RESERVED or plain.startswith("token ") or MARK in name:
        raise BadInputError(
            f"name: expected a name without a colon that is not reserved "
            f"({', '.join(sorted(RESERVED))}), got {name!r}"
        )


class Tokens:
    """The tokens of one database."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(
        self, role: str, name: str = "", expires: float | None = None, *, another: bool = False
    ) -> str:
        """Create a token and return its secret, which is not stored.

        ``name`` is the person's account; without a name the token is an account of its own.
        ``expires``: seconds since the epoch.  Raises BadInputError for an unknown role or a name
        that no token may have, ConflictError for the name of a valid token unless ``another`` token
        of it is wanted.
        """
        require_known(role)
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

        def make(connection: Connection) -> str:
            same = connection.execute(select(tokens).where(tokens.c.name == name)).all()
            if name and not another and any(token_of(other).valid for other in same):
                raise ConflictError(
                    f"name: expected one without a valid token, got {name!r}; revoke it first"
                )
            connection.execute(insert(tokens), row)
            return secret

        def find(connection: Connection) -> str | None:
            made = connection.execute(select(tokens.c.id).where(tokens.c.digest == row["digest"]))
            return None if made.first() is None else secret

        return write_once(self._database, make, find)

    def of_person(self, subject: str, names: Iterable[str], role: Role) -> AccountToken:
        """Return the token of a person of an identity provider; create it at the first sign-in.

        It has no secret.  ``subject`` identifies the person; their account is the first of
        ``names`` that is valid and that no token ever had.
        """
        digest = f"{ELSEWHERE}{digest_of(subject)}"[: len(digest_of(""))]
        number = secrets.token_hex(4)
        row = {"id": number, "role": role, "digest": digest, "created": time.time()}
        query = select(tokens).where(tokens.c.digest == digest)
        with self._database.read() as connection:
            found = connection.execute(query).one_or_none()
        if found is not None:
            return token_of(found)
        new = insert_new(tokens, sqlite=self._database.sqlite).on_conflict_do_nothing()
        with self._database.write() as connection:
            taken = set(connection.execute(select(tokens.c.account)).scalars())
            name = next(_free(names, number, taken))
            connection.execute(new, row | {"name": name, "account": name})
            return token_of(connection.execute(query).one())

    def put_role(self, token_id: str, role: Role) -> AccountToken:
        """Change the role of a token and of its current sign-ins."""
        is_token = tokens.c.id == token_id
        with self._database.write() as connection:
            connection.execute(update(tokens).where(is_token).values(role=role))
            return token_of(connection.execute(select(tokens).where(is_token)).one())

    def list(self) -> list[AccountToken]:
        """Return all tokens, oldest first, including revoked and expired ones."""
        with self._database.read() as connection:
            rows = connection.execute(select(tokens).order_by(tokens.c.created)).all()
        return [token_of(row) for row in rows]

    def revoke(self, token_id: str) -> AccountToken:
        """End a token's validity now; raises NotFoundError for an unknown id."""
        with self._database.write() as connection:
            is_token = tokens.c.id == token_id
            row = connection.execute(select(tokens).where(is_token)).one_or_none()
            if row is None:
                raise NotFoundError(f"token: expected the id of a token, got {token_id!r}")
            if row.revoked is None:
                connection.execute(update(tokens).where(is_token).values(revoked=time.time()))
            return token_of(connection.execute(select(tokens).where(is_token)).one())

    def check(self, secret: str) -> AccountToken | None:
        """Return the valid token with this secret, or None."""
        digest = digest_of(secret)
        row = self._database.look(_OF_DIGEST, {"digest": digest})
        # The timing of the look-up by digest reveals nothing of a secret; the final comparison
        # takes constant time nevertheless.
        if row is None or not hmac.compare_digest(row.digest.encode(), digest.encode()):
            return None
        token = token_of(row)
        return token if token.valid else None


_OF_DIGEST = Statement(select(tokens).where(tokens.c.digest == bindparam("digest")))


def digest_of(secret: str) -> str:
    """Return the stored digest of a secret."""
    return hashlib.sha256(secret.encode("utf-8", "surrogateescape")).hexdigest()


def token_of(row: Row[Any]) -> AccountToken:
    """Return the token of a row, as it is now."""
    valid = row.revoked is None and (row.expires is None or time.time() < row.expires)
    times = {name: time_of(getattr(row, name)) for name in ("created", "expires", "revoked")}
    return AccountToken.of(row, **times, valid=valid)


def _free(names: Iterable[str], number: str, taken: Container[str]) -> Iterator[str]:
    """Yield the names that a new account may have; one that holds ``number`` is the last."""
    for name in names:
        with suppress(BadInputError):
            require_token_name(name)
            if name not in taken:
                yield name
    yield f"person {number}"


@dataclass(frozen=True, slots=True)
class SignIn:
    """Identity behind a cookie: a person's ``token``, or the server's own (None).

    ``account`` is the author of its edits; ``owner`` is the digest of the server's own token at the
    time of the sign-in, or "".
    """

    account: str
    token: AccountToken | None
    owner: str


class SignIns:
    """The sign-ins of one database."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(self, account: str, token: str | None, owner: str, expires: float) -> str:
        """Create a sign-in and return its id for the cookie.

        ``token``: a token's id; ``owner``: the digest of the server's own; ``expires``: seconds
        since the epoch.  Expired sign-ins are removed.
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
        """Return the sign-in of a cookie; None: it or its token is no longer valid."""
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
        """End a sign-in; an unknown secret is no error."""
        with self._database.write() as connection:
            connection.execute(delete(sign_ins).where(sign_ins.c.digest == digest_of(secret)))
