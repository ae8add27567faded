"""The page's sessions: a random id in a cookie, valid until sign-out or revocation of the token."""

from __future__ import annotations

import secrets
import time
from dataclasses import dataclass, replace

from pointbrush.accounts.accounts import SignIn, digest_of
from pointbrush.errors import ReadOnlyError
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.team.accounts import AccountToken

SESSION_DAYS = 30
MOST_KEPT = 10_000
"""Most sessions in memory, which are used if the database is read-only."""


@dataclass(frozen=True, slots=True)
class _Kept:
    """A session in memory; ``secret``: the secret of the person's token, which is checked again."""

    sign_in: SignIn
    secret: str
    expires: float


class WebSessions:
    """Sessions of one server, in the shared database, or in memory if it is read-only."""

    def __init__(self, store: WorkspaceStore, own_token: str) -> None:
        """``own_token``: the server's own; sessions made with another one are void."""
        self._store = store
        self._own = digest_of(own_token)
        self._kept: dict[str, _Kept] = {}

    def begin(self, account: str, token: AccountToken | None, secret: str) -> str:
        """Begin a session of a person's token, or of the server's own (None); return its id.

        Raises ReadOnlyError for a token without a ``secret`` where nothing can be written.
        """
        expires = time.time() + SESSION_DAYS * 86_400
        if token is not None and token.expires is not None:
            expires = min(expires, token.expires.timestamp())
        owner = self._own if token is None else ""
        number = None if token is None else token.id
        try:
            return self._store.sign_ins.add(account, number, owner, expires)
        except ReadOnlyError:
            if not secret:
                raise
            made = secrets.token_urlsafe(32)
            self._kept[digest_of(made)] = _Kept(SignIn(account, token, owner), secret, expires)
            while len(self._kept) > MOST_KEPT:
                del self._kept[next(iter(self._kept))]
            return made

    def check(self, session: str) -> SignIn | None:
        """Return the sign-in of a session, or None if it is no longer valid."""
        kept = self._kept.get(digest_of(session))
        found = self._store.sign_ins.check(session) if kept is None else self._check_kept(kept)
        if found is not None and found.token is None and found.owner != self._own:
            return None
        return found

    def earlier_account(self, session: str) -> str | None:
        """Return the account of a session of the server's own token, now or before it changed."""
        found = self._store.sign_ins.check(session)
        return found.account if found is not None and found.token is None else None

    def _check_kept(self, kept: _Kept) -> SignIn | None:
        if kept.expires < time.time():
            return None
        if kept.sign_in.token is None:
            return kept.sign_in
        token = self._store.tokens.check(kept.secret)
        return None if token is None else replace(kept.sign_in, token=token)

    def end(self, session: str) -> None:
        """End a session; an unknown one is no error."""
        if self._kept.pop(digest_of(session), None) is None:
            self._store.sign_ins.end(session)
