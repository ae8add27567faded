"""Authentication of callers: tokens, the page's cookie, roles, Origin and Host."""

from __future__ import annotations

import hmac
import socket
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Depends, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.routing import APIRoute
from fastapi.security import APIKeyCookie, HTTPBearer
from fastapi.security.base import SecurityBase
from starlette.requests import HTTPConnection

from pointbrush.accounts.accounts import OWNER, PARTICIPANT, digest_of
from pointbrush.accounts.roles import ROLES, Role, require
from pointbrush.database.job import Job
from pointbrush.errors import (
    ForbiddenError,
    NotFoundError,
    TooManyRequestsError,
    UnauthorizedError,
)
from pointbrush.labels.recordings import Known
from pointbrush.settings import Settings
from pointbrush.teamwork.access import is_participant
from pointbrush.values.team.accounts import AccountToken
from pointbrush.web.context import known_query
from pointbrush.web.security.browser_accounts import BrowserAccounts, new_account
from pointbrush.web.security.clients import (
    KNOWN_CLIENTS,
    Clients,
    RateLimit,
    address_in,
    is_loopback,
)
from pointbrush.web.security.cookies import Cookie
from pointbrush.web.security.roles import PARTICIPANT_CALLS, PREFIX, role_of
from pointbrush.web.security.sessions import SESSION_DAYS, WebSessions
from pointbrush.web.security.sign_ins import SignIns
from pointbrush.workspace import Workspace

if TYPE_CHECKING:
    from pointbrush.web.security.oidc import Person, Provider

COOKIE = "pointbrush_session"
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


@dataclass(frozen=True)
class Principal:
    """An authenticated caller.

    ``author`` is the account of the caller's edits, ``name`` its displayed name; ``shared``: the
    caller has the server's own token, which several people may use, each with a chosen name.
    """

    author: str
    name: str
    role: Role
    shared: bool = False


class Gate:
    """Checks tokens, hosts and origins for one server."""

    def __init__(self, workspace: Workspace, settings: Settings, token: str) -> None:
        self._workspace = workspace
        self._token = token.encode()
        self._hosts = host_names(settings)
        self._local = is_loopback(settings.host)
        self.clients = Clients(settings.trusted_proxies)
        self.sign_ins = SignIns()
        self.sessions = WebSessions(workspace.labels, token)
        self._browsers = BrowserAccounts(workspace.labels.signing_keys)
        issuer = settings.oidc_issuer
        self.provider: Provider | None = None
        if issuer:
            from pointbrush.web.security.oidc import (
                Provider,  # imports libraries that few servers need
            )

            self.provider = Provider(settings, workspace.labels.signing_keys)
        self._right: dict[str, None] = {}
        self._tries = settings.wrong_tokens_per_minute
        self._wrong = RateLimit(self._tries / 60, burst=self._tries)

    def check(self, secret: str, connection: HTTPConnection) -> Principal:
        """Return the holder of ``secret``, compared in constant time; raises UnauthorizedError."""
        if self._is_own(secret):
            self._note(secret)
            return Principal(OWNER, OWNER, "admin", shared=True)
        token = self._workspace.labels.tokens.check(secret)
        if token is None:
            account = self.participant(secret, connection)
            return Principal(account, PARTICIPANT, "annotator")
        self._note(secret)
        return _person(token)

    def participant(self, code: str, connection: HTTPConnection) -> str:
        """Return the account of a study's participant with this code; raises UnauthorizedError."""
        account = self._workspace.labels.studies.account_of(code)
        if account is None:
            raise self._refusal(connection, "code" if "code" in connection.path_params else "token")
        self._note(code)
        connection.state.known = True
        return account

    def participant_cookie(self, code: str, connection: HTTPConnection) -> Cookie:
        """Return the cookie that admits a participant by their code."""
        return _session_cookie(connection, code)

    def owner(self, connection: HTTPConnection) -> Principal | None:
        """Return the caller with the server's own token, checked without the database."""
        bearer = bearer_of(connection.headers)
        if not bearer or not self._is_own(bearer):
            return None
        connection.state.known = True
        return self.check(bearer, connection)

    def bucket_of(self, bearer: str, connection: HTTPConnection) -> str:
        """Return the key under which a request is counted: a proven token's, or an address's.

        A client that tries many tokens therefore has one bucket for all of them.
        """
        known = bearer and digest_of(bearer)
        return known if known in self._right else self.clients.address(connection)

    def _note(self, secret: str) -> None:
        digest = digest_of(secret)
        self._right.pop(digest, None)
        self._right[digest] = None
        if len(self._right) > KNOWN_CLIENTS:
            self._right.pop(next(iter(self._right)), None)

    def sign_in(self, secret: str, connection: HTTPConnection) -> tuple[Principal, list[Cookie]]:
        """Begin a session for the holder of ``secret``; return the cookies to set.

        Raises UnauthorizedError.
        """
        principal = self.check(secret, connection)
        if principal.shared:
            account = self._account_of_browser(connection)
            session = self.sessions.begin(account, None, secret)
            kept = self._browsers.cookies(connection, account)
            return self._sharer(account), [_session_cookie(connection, session), *kept]
        token = self._workspace.labels.tokens.check(secret)
        session = self.sessions.begin(principal.author, token, secret)
        return principal, [_session_cookie(connection, session)]

    def sign_in_person(self, person: Person, role: Role, connection: HTTPConnection) -> Cookie:
        """Begin a session for a person from the provider; ``role``: the role of a new account.

        Raises ForbiddenError if the person's token was revoked; ReadOnlyError.
        """
        tokens = self._workspace.labels.tokens
        token = tokens.of_person(person.subject, person.names, person.role or role)
        if not token.valid:
            raise ForbiddenError("expected an account with access, this access was revoked")
        if person.role not in (None, token.role):
            token = tokens.put_role(token.id, person.role)
        return _session_cookie(connection, self.sessions.begin(token.account, token, ""))

    def _account_of_browser(self, connection: HTTPConnection) -> str:
        """Return the account in the browser's cookie, or a new one.

        For a browser that signed in before this cookie existed, the session has the account.
        """
        session = connection.cookies.get(cookie_name(connection), "")
        known = self._browsers.read(connection) or self.sessions.earlier_account(session)
        return known or new_account()

    def sign_out(self, connection: HTTPConnection) -> None:
        """End the session of the cookie, if there is one; the browser keeps its account."""
        session = connection.cookies.get(cookie_name(connection))
        if session:
            self.sessions.end(session)

    def _is_own(self, secret: str) -> bool:
        return hmac.compare_digest(secret.encode("utf-8", "surrogateescape"), self._token)

    def _of_session(self, session: str, connection: HTTPConnection) -> Principal:
        found = self.sessions.check(session)
        if found is None:
            account = self.participant(session, connection)
            return Principal(account, PARTICIPANT, "annotator")
        if found.token is not None:
            return _person(found.token)
        return self._sharer(found.account)

    def _sharer(self, account: str) -> Principal:
        name = self._workspace.labels.accounts.name(account)
        return Principal(account, name, "admin", shared=True)

    def _refusal(
        self, connection: HTTPConnection, kind: str = "token"
    ) -> UnauthorizedError | TooManyRequestsError:
        """Return the refusal of a wrong token; wrong tokens never block a right one."""
        try:
            self._wrong.spend(self.clients.address(connection))
        except TooManyRequestsError:
            return TooManyRequestsError(
                f"expected at most {self._tries} wrong tokens a minute from one address"
            )
        return UnauthorizedError(f"expected a valid {kind}, got a wrong, expired or revoked one")

    def admit(self, connection: HTTPConnection) -> Principal:
        """Return the caller of a request or socket; raise UnauthorizedError or ForbiddenError."""
        bearer = bearer_of(connection.headers)
        session = connection.cookies.get(cookie_name(connection))
        if bearer:
            principal = self.check(bearer, connection)
        elif session:
            principal = self._of_session(session, connection)
        else:
            raise UnauthorizedError("expected 'Authorization: Bearer TOKEN' or the page's cookie")
        unsafe = connection.scope.get("method", "GET") not in SAFE_METHODS
        if connection.scope["type"] == "websocket" or (unsafe and not bearer):
            require_same_origin(connection)
        connection.state.known = True  # the log has no limit for known callers
        return principal

    def admit_to(self, connection: HTTPConnection) -> Principal:
        """Return the caller of a request with their role in the project of the request.

        Raises as ``admit``, ForbiddenError for a participant, and NotFoundError for a recording or
        project without access.
        """
        principal = self.admit(connection)
        call = connection.scope["method"], connection.scope["route"].path.removeprefix(PREFIX)
        if is_participant(principal.author) and call not in PARTICIPANT_CALLS:
            raise ForbiddenError("expected a call that a study needs, got another one")
        access, places = self._workspace.labels.team.access, connection.path_params
        roles = [principal.role]
        for kind, ask in (("seq", access.to_sequence), ("p", access.to_project)):
            if kind in places:
                role = ask(places[kind], principal.author, principal.role)
                if role is None:
                    raise _unknown(kind, places[kind])
                roles.append(role)
        return replace(principal, role=min(roles, key=ROLES.index))

    def role_in(self, principal: Principal, sequence: str) -> Role | None:
        """Return the role of a caller in a recording, or None without access."""
        access = self._workspace.labels.team.access
        return access.to_sequence(sequence, principal.author, principal.role)

    def roles_in(self, principal: Principal, sequences: Iterable[str]) -> dict[str, Role]:
        """Return the roles of a caller in recordings; recordings without access are left out."""
        access = self._workspace.labels.team.access
        return access.to_sequences(sequences, principal.author, principal.role)

    def may_see(self, principal: Principal, sequence: str | None) -> bool:
        """Return whether a caller may see a recording; always for None, no recording."""
        return sequence is None or self.role_in(principal, sequence) is not None

    def may_see_job(self, principal: Principal, job: Job) -> bool:
        """Return whether a job is the caller's own, or they may see its recording and project."""
        if job.owner == principal.author or is_participant(principal.author):
            return job.owner == principal.author
        project = (job.request or {}).get("project")  # an import's, before the recording is there
        access = self._workspace.labels.team.access
        if project and access.to_project(project, principal.author, principal.role) is None:
            return False
        if job.sequence is None:
            return True
        role = access.to_sequence(job.sequence, principal.author, principal.role, job.created)
        return role is not None

    def may_see_deleted(self, principal: Principal, known: Known) -> bool:
        """Return whether a caller may see a deleted recording, even if its id is in use again."""
        access = self._workspace.labels.team.access
        return access.to_number(known.number, principal.author, principal.role) is not None

    def require_seen(self, principal: Principal, *sequences: str) -> None:
        """Raise NotFoundError unless a caller may see all of the recordings."""
        for sequence in sequences:
            if not self.may_see(principal, sequence):
                raise _unknown("seq", sequence)

    def is_own(self, connection: HTTPConnection, principal: Principal) -> bool:
        """Return whether the caller is the server's owner on this machine, without a proxy."""
        return principal.shared and self._local and self.clients.is_direct(connection)

    def require_host(self, connection: HTTPConnection) -> None:
        """Raise ForbiddenError unless the Host header names this server."""
        header = connection.headers.get("host", "")
        if not self.knows_host(header):
            raise ForbiddenError(
                f"Host: expected a name of this server, got {header[:100]!r} "
                "(see the option allowed_hosts)"
            )

    def knows_host(self, header: str) -> bool:
        """Whether a Host header names this server.

        A page that rebinds its DNS name to us sends that name, so names must be known ones;
        an address cannot be rebound.
        """
        name = header.rsplit(":", 1)[0] if not header.endswith("]") else header
        name = name.strip("[]").lower().rstrip(".")
        return name in self._hosts or address_in(name) is not None


def _unknown(kind: str, name: str) -> NotFoundError:
    what = "sequence" if kind == "seq" else "project"
    return NotFoundError(f"{what}: expected a known id, got {name!r}")


def _person(token: AccountToken) -> Principal:
    return Principal(token.account, token.name or token.account, token.role)


def host_names(settings: Settings) -> frozenset[str]:
    """Names this server answers to: loopback, the bound one, the machine's, the configured."""
    machine = socket.gethostname().lower()
    names = {"localhost", settings.host.lower(), machine, f"{machine.split('.')[0]}.local"}
    names.update(host.strip().lower() for host in settings.allowed_hosts.split(","))
    return frozenset(names - {""})


def bearer_of(headers: Mapping[str, str]) -> str:
    """The bearer token of an Authorization header, or ''."""
    scheme, _, secret = headers.get("authorization", "").partition(" ")
    return secret.strip() if scheme.lower() == "bearer" else ""


def cookie_name(connection: HTTPConnection) -> str:
    """Return the cookie's name, which contains the port, because cookies ignore ports."""
    return f"{COOKIE}_{connection.url.port or connection.url.scheme}".replace("ws", "http")


def _session_cookie(connection: HTTPConnection, session: str) -> Cookie:
    return Cookie(cookie_name(connection), session, SESSION_DAYS)


def require_same_origin(connection: HTTPConnection) -> None:
    """Raise ForbiddenError if a browser reports a call from another site's page.

    A caller without an Origin is not a browser and cannot carry another user's cookie.
    """
    origin = connection.headers.get("origin")
    if origin is None:
        if connection.headers.get("sec-fetch-site", "same-origin") in ("same-origin", "none"):
            return
        raise ForbiddenError("expected a call from this server's own page, got one from another")
    scheme, _, netloc = origin.lower().partition("://")
    # A page over plain HTTP may have been modified on its way, so that it is refused under HTTPS.
    cleartext = scheme != "https" and connection.url.is_secure
    if cleartext or netloc != connection.headers.get("host", "").lower():
        raise ForbiddenError(f"expected this server's own origin, got {origin[:100]!r}")


SCHEMES: tuple[SecurityBase, ...] = (
    HTTPBearer(description="a token of `pointbrush token add`"),
    APIKeyCookie(name=COOKIE, description="set by the page's sign-in"),
)
"""Security schemes for the OpenAPI; ``caller`` reads both kinds of credentials itself."""


async def caller(request: Request) -> Principal:
    """Return the caller if their role may use the route; a dependency of routes.

    Raises UnauthorizedError or ForbiddenError.
    """
    gate: Gate = request.app.state.gate
    principal = gate.owner(request)
    if principal is None:
        principal = await run_in_threadpool(gate.admit_to, request)
    needed = role_of(request.scope["route"])
    if needed is None:
        raise ForbiddenError("expected a call with a role, this one has none")
    require(principal.role, needed)
    return principal


Caller = Annotated[Principal, Depends(caller)]


def requires_caller(route: APIRoute) -> bool:
    """Return whether a route needs an authenticated caller."""
    return any(part.call is caller for part in route.dependant.dependencies)


async def gate_of(request: Request) -> Gate:
    """The gate of this server; on the event loop, which takes no thread."""
    gate: Gate = request.app.state.gate
    return gate


TheGate = Annotated[Gate, Depends(gate_of)]


def resource(tag: str) -> APIRouter:
    """Return the router of a REST resource; all its calls need an authenticated caller."""
    return APIRouter(
        prefix=PREFIX, tags=[tag], dependencies=[Depends(caller), Depends(known_query)]
    )
