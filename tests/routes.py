"""The calls of the server with the roles that they need."""

from __future__ import annotations

from pointbrush.accounts.roles import Role
from pointbrush.web.app import ROUTERS
from pointbrush.web.security.roles import PREFIX, role_of

OPEN = frozenset({
    ("POST", "/session"),
    ("GET", "/oidc"),
    ("GET", "/oidc/login"),
    ("GET", "/oidc/callback"),
    ("GET", "/healthz"),
    ("GET", "/readyz"),
    ("GET", "/docs"),
    ("GET", "/docs/{name}"),
    ("GET", "/openapi.json"),
    ("GET", "/trust"),
    ("GET", "/trust/address.svg"),
    ("GET", "/trust/authority.crt"),
    ("GET", "/"),
    ("GET", "/check-headset"),
    ("GET", "/study/{code}"),
    ("POST", "/study/{code}"),
    ("GET", "/study/{code}/step"),
    ("POST", "/study/{code}/step"),
    ("POST", "/study/{code}/log"),
    ("GET", "/{path:asset}"),
})  # fmt: skip
"""Calls that need no token: signing in, public data, and calls with a participant's code."""
CALLS: dict[tuple[str, str], Role | None] = {
    (method, route.path.removeprefix(PREFIX)): role_of(route)  # type: ignore[attr-defined]
    for router in ROUTERS
    for route in router.routes
    for method in getattr(route, "methods", None) or {"WEBSOCKET"}
    if method != "HEAD"
}
"""Role of each call, None for one that states none."""
ROUTES: dict[tuple[str, str], Role] = {
    **{call: role for call, role in CALLS.items() if role is not None},
    ("WEBSOCKET", "/stream"): "viewer",
}
