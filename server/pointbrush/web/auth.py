"""Who is calling: tokens, the page's cookie, roles, Origin and Host."""

from __future__ import annotations

import hmac
import ipaddress
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Depends, Request
from fastapi.security import APIKeyCookie, HTTPBearer
from starlette.requests import HTTPConnection

from pointbrush.errors import ForbiddenError, UnauthorizedError
from pointbrush.roles import Role, require
from pointbrush.settings import Settings
from pointbrush.web.clients import Clients, is_loopback
from pointbrush.web.roles import ROUTES, call_of
from pointbrush.workspace import Workspace

COOKIE = "pointbrush_session"
COOKIE_DAYS = 30
OWNER = "owner"
"""Author of edits made with the server's own token by somebody who gave no name."""
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


@dataclass(frozen=True)
class Principal:
    """An authenticated caller; ``shared``: the server's own token, which several may use."""

    author: str
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

    def check(self, secret: str) -> Principal:
        """Who holds ``secret``; raises UnauthorizedError.  Compared in constant time."""
        if hmac.compare_digest(secret.encode("utf-8", "surrogateescape"), self._token):
            return Principal(OWNER, "admin", shared=True)
        token = self._workspace.store.tokens.check(secret)
        if token is None:
            raise UnauthorizedError("expected a valid token, got a wrong, expired or revoked one")
        return Principal(token.name or f"token {token.id}", token.role)

    def admit(self, connection: HTTPConnection) -> Principal:
        """The caller of a request or socket; raises UnauthorizedError or ForbiddenError."""
        bearer = bearer_of(connection.headers)
        secret = bearer or connection.cookies.get(cookie_name(connection))
        if not secret:
            raise UnauthorizedError("expected 'Authorization: Bearer TOKEN' or the page's cookie")
        principal = self.check(secret)
        unsafe = connection.scope.get("method", "GET") not in SAFE_METHODS
        if connection.scope["type"] == "websocket" or (unsafe and not bearer):
            require_same_origin(connection)
        return principal

    def is_own(self, connection: HTTPConnection, principal: Principal) -> bool:
        """Whether who started this server calls it, on this machine and through no proxy."""
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
        return name in self._hosts or _is_address(name)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


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
    """Cookies ignore ports, so that two servers on one machine need names of their own."""
    return f"{COOKIE}_{connection.url.port or connection.url.scheme}".replace("ws", "http")


def require_same_origin(connection: HTTPConnection) -> None:
    """Raise ForbiddenError when a browser says that another site's page is calling.

    A caller without an Origin is no browser: it cannot carry somebody else's cookie.
    """
    origin = connection.headers.get("origin")
    if origin is None:
        if connection.headers.get("sec-fetch-site", "same-origin") in ("same-origin", "none"):
            return
        raise ForbiddenError("expected a call from this server's own page, got one from another")
    netloc = origin.partition("://")[2].lower()
    if netloc != connection.headers.get("host", "").lower():
        raise ForbiddenError(f"expected this server's own origin, got {origin[:100]!r}")


_bearer = HTTPBearer(auto_error=False, description="a token of `pointbrush token add`")
_cookie = APIKeyCookie(name=COOKIE, auto_error=False, description="set by the page's sign-in")


def caller(
    request: Request,
    _header: Annotated[Any, Depends(_bearer)],
    _session: Annotated[Any, Depends(_cookie)],
) -> Principal:
    """A dependency: who calls, once the table says that their role may.

    Raises UnauthorizedError or ForbiddenError.
    """
    gate: Gate = request.app.state.gate
    principal = gate.admit(request)
    require(principal.role, ROUTES[call_of(request.method, request.scope["route"].path)])
    return principal


Caller = Annotated[Principal, Depends(caller)]
