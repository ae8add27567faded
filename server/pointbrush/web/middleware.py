"""Checks of every request before its route: Host, rate, body size; and security headers."""

from __future__ import annotations

import asyncio
import logging
import re
import time
from collections.abc import Mapping

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from pointbrush.errors import (
    BadInputError,
    PointbrushError,
    TooLargeError,
)
from pointbrush.settings import Settings
from pointbrush.streaming.metrics import Metrics
from pointbrush.system.resources import shortage
from pointbrush.web.problems import loggable, problem_of
from pointbrush.web.security.auth import Gate, bearer_of
from pointbrush.web.security.clients import RateLimit

log = logging.getLogger(__name__)
PLAIN_HOST = re.compile(r"[\w.:\[\]-]+", re.ASCII)
BODY_PAUSE = 30.0
"""Longest silence in the middle of a body, seconds: a slow-loris upload ends here."""
POLICY = (
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; "
    "img-src 'self' data: blob:; style-src 'self'; font-src 'self'; "
    "connect-src 'self' {sockets}; object-src 'none'; base-uri 'none'; form-action 'self'; "
    "frame-ancestors 'none'"
)
HEADERS: Mapping[str, str] = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Permissions-Policy": (
        "xr-spatial-tracking=(self), camera=(), microphone=(), geolocation=(), payment=()"
    ),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class Guard:
    """Outermost ASGI layer around the app."""

    def __init__(self, app: ASGIApp, *, settings: Settings, gate: Gate, metrics: Metrics) -> None:
        self.app, self.settings, self.gate, self.metrics = app, settings, gate, metrics
        self.rate = RateLimit(settings.requests_per_second)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check a request, then call the app; sockets are checked after their handshake."""
        if "scheme" in scope:
            # Set once here, so that cookies, Origin and links are correct behind a proxy.
            scope["scheme"] = self.gate.clients.scheme(HTTPConnection(scope))
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        secured = self._secured(send, scope["method"], headers.get("host", ""))
        try:
            self._admit(scope, headers)
            multipart = headers.get("content-type", "").startswith("multipart/")
            limit = self._body_limit(scope, headers, multipart)
        except PointbrushError as error:
            await problem_of(error)(scope, receive, secured)
            return
        seconds = self.settings.upload_seconds if multipart else self.settings.body_seconds
        try:
            await self.app(scope, _Limited(receive, limit, seconds), secured)
        except Exception as error:  # during an answer; an earlier error is answered as a problem
            if (short := shortage(_first(error))) is None:
                raise
            path = loggable(scope["path"])
            log.warning("%s %s is broken off: %s", scope["method"], path, short)

    def _admit(self, scope: Scope, headers: Headers) -> None:
        connection = HTTPConnection(scope)
        self.gate.require_host(connection)
        self.rate.spend(self.gate.bucket_of(bearer_of(headers), connection))

    def _body_limit(self, scope: Scope, headers: Headers, multipart: bool) -> int:
        limit = self.settings.max_upload if multipart else self.settings.max_body
        if scope["path"].endswith("/annotation"):
            limit = max(limit, 4 * self.settings.max_frame_points)
        stated = headers.get("content-length", "0")
        if not (stated.isascii() and stated.isdigit()):
            raise BadInputError(f"Content-Length: expected a number, got {stated[:40]!r}")
        if int(stated) > limit:
            raise TooLargeError(f"body: expected at most {limit} bytes, got {stated}")
        return limit

    def _secured(self, send: Send, method: str, host: str) -> Send:
        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                status = str(message["status"])
                self.metrics.requests.labels(method[:10], status).inc()
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
                sockets = f"ws://{host} wss://{host}" if PLAIN_HOST.fullmatch(host) else ""
                headers.setdefault("Content-Security-Policy", POLICY.format(sockets=sockets))
                headers.setdefault("Cache-Control", "no-store")
            await send(message)

        return with_headers


def _first(error: BaseException) -> BaseException:
    """Return the error that others were raised from."""
    while error.__cause__ is not None:
        error = error.__cause__
    return error


class _Limited:
    """``receive`` that counts the body and gives up on a silent or slow sender."""

    def __init__(self, receive: Receive, limit: int, seconds: int) -> None:
        """``limit`` of a body in bytes; ``seconds`` in which it must have come whole."""
        self._receive, self._limit, self._seconds = receive, limit, seconds
        self._seen, self._complete = 0, False
        self._end = time.monotonic() + seconds

    async def __call__(self) -> Message:
        if self._complete:
            return await self._receive()
        left = self._end - time.monotonic()
        try:
            async with asyncio.timeout(min(BODY_PAUSE, max(left, 0.0))):
                message = await self._receive()
        except TimeoutError:
            if left > BODY_PAUSE:
                return {"type": "http.disconnect"}
            raise HTTPException(
                408, f"body: expected it whole within {self._seconds} seconds, got a part of it"
            ) from None
        self._seen += len(message.get("body", b""))
        self._complete = not message.get("more_body", False)
        if self._seen > self._limit:
            # An HTTPException, because FastAPI hides any other error while it reads a body.
            raise HTTPException(413, f"body: expected at most {self._limit} bytes, got more")
        return message
