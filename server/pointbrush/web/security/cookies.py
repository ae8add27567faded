"""The page's two cookies: one for the session, one for a browser's account."""

from __future__ import annotations

from dataclasses import dataclass

from starlette.requests import HTTPConnection
from starlette.responses import Response

DAY_SECONDS = 86_400


@dataclass(frozen=True, slots=True)
class Cookie:
    """A cookie to be set."""

    name: str
    value: str
    days: int
    """Days for which the browser keeps the cookie; 0: it is dropped."""


def set_cookie(connection: HTTPConnection, response: Response, cookie: Cookie) -> None:
    """Add a cookie to ``response`` that no script can read and no other site sends."""
    response.set_cookie(
        cookie.name,
        cookie.value,
        max_age=cookie.days * DAY_SECONDS,
        httponly=True,
        samesite="strict",
        secure=connection.url.is_secure,
    )
