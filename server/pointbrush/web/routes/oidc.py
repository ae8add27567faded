"""Sign-in with an OpenID Connect provider: redirect to it, and callback with its answer."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TYPE_CHECKING

from anyio import to_thread
from fastapi import APIRouter, Request, Response
from fastapi.responses import RedirectResponse
from pydantic import BaseModel

from pointbrush.errors import ForbiddenError, NotFoundError, PointbrushError
from pointbrush.web.page import wants_html
from pointbrush.web.security.auth import Gate, TheGate, cookie_name
from pointbrush.web.security.cookies import set_cookie
from pointbrush.web.security.roles import PREFIX

if TYPE_CHECKING:
    from pointbrush.web.security.oidc import Provider

log = logging.getLogger(__name__)
PLACE = f"{PREFIX}/oidc"
router = APIRouter(prefix=PLACE, include_in_schema=False)
REFUSED = "/?sign-in={reason}"
"""Address for a browser after a failed sign-in; the page shows the reason."""


class ProviderOut(BaseModel):
    """Name of the provider, or None where there is none."""

    name: str | None


def _provider(request: Request) -> Provider:
    gate: Gate = request.app.state.gate
    if gate.provider is None:
        raise NotFoundError("sign-in: expected a provider (the option oidc_issuer), there is none")
    return gate.provider


def _kept(request: Request) -> str:
    """Return the name of the cookie of a running sign-in."""
    return cookie_name(request).replace("session", "oidc")


def _back(request: Request) -> str:
    """Return the callback's address, with the server name that this browser uses."""
    return f"{request.url.scheme}://{request.headers['host']}{PLACE}/callback"


@router.get("")
def provider(gate: TheGate) -> ProviderOut:
    """Return the provider for the page's sign-in."""
    return ProviderOut(name=None if gate.provider is None else gate.provider.name)


@router.get("/login")
async def login(request: Request) -> Response:
    """Send the browser to the provider."""
    return await _in_own_thread(request, _login)


@router.get("/callback")
async def callback(request: Request) -> Response:
    """Take the provider's answer, begin a session, and go to the page."""
    return await _in_own_thread(request, _callback)


async def _in_own_thread(request: Request, step: Callable[[Request], Response]) -> Response:
    """Run a step of a sign-in in a separate thread, because it may wait long."""
    gate: Gate = request.app.state.gate
    try:
        with gate.sign_ins.one_of(gate.clients.address(request)):
            return await to_thread.run_sync(step, request, limiter=gate.sign_ins.threads)
    except PointbrushError as error:
        return _refused(request, error)


def _login(request: Request) -> Response:
    try:
        known = _provider(request)
        address, kept = known.begin(_back(request))
    except PointbrushError as error:
        return _refused(request, error)
    response = RedirectResponse(address, status_code=303)
    # Lax: the browser must send the cookie when it returns from another site.
    response.set_cookie(
        _kept(request), kept, max_age=known.flow_seconds, path=PLACE, httponly=True, samesite="lax",
        secure=request.url.is_secure,
    )  # fmt: skip
    return response


def _callback(request: Request) -> Response:
    gate: Gate = request.app.state.gate
    try:
        known = _provider(request)
        kept = request.cookies.get(_kept(request), "")
        person = known.finish(kept, dict(request.query_params), _back(request))
        session = gate.sign_in_person(person, known.first_role, request)
    except PointbrushError as error:
        response = _refused(request, error)
    else:
        response = RedirectResponse("/", status_code=303)
        set_cookie(request, response, session)
    response.delete_cookie(
        _kept(request), path=PLACE, httponly=True, samesite="lax", secure=request.url.is_secure
    )
    return response


def _refused(request: Request, error: PointbrushError) -> Response:
    """Redirect a browser to the page, which shows the error; answer other clients as usual."""
    if not wants_html(request):
        raise error
    log.warning("sign-in: %s", error.whole)
    reason = "forbidden" if isinstance(error, ForbiddenError) else "failed"
    return RedirectResponse(REFUSED.format(reason=reason), status_code=303)
