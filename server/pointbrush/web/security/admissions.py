"""Closing of open sockets when their token or session is no longer valid."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator

from starlette.websockets import WebSocket

from pointbrush.errors import PointbrushError, UnauthorizedError
from pointbrush.streaming.session import ViewerSession

RECHECK_SECONDS = 2.5
"""Pause between two checks of all open sockets."""

log = logging.getLogger(__name__)
Credentials = tuple[str, str]
"""The headers ``Authorization`` and ``Cookie``."""


class Admissions:
    """The open sockets of one server; sockets with the same credentials are checked together."""

    def __init__(self, check: Callable[[WebSocket], Awaitable[object]]) -> None:
        """``check`` raises UnauthorizedError for a socket with invalid credentials."""
        self._check = check
        self._open: dict[Credentials, dict[ViewerSession, WebSocket]] = {}

    @contextlib.asynccontextmanager
    async def running(self) -> AsyncIterator[Admissions]:
        """Check the open sockets periodically until the context ends."""
        checking = asyncio.create_task(self._check_all())
        try:
            yield self
        finally:
            checking.cancel()

    @contextlib.contextmanager
    def watching(self, socket: WebSocket, session: ViewerSession) -> Iterator[None]:
        """Count a socket among the open ones until the context ends."""
        headers = socket.headers
        credentials = headers.get("authorization", ""), headers.get("cookie", "")
        mine = self._open.setdefault(credentials, {})
        mine[session] = socket
        try:
            yield
        finally:
            del mine[session]
            if not mine and self._open.get(credentials) is mine:
                del self._open[credentials]

    async def _check_all(self) -> None:
        while True:
            await asyncio.sleep(RECHECK_SECONDS)
            try:
                for sessions in list(self._open.values()):
                    await self._check_one(sessions)
            except (PointbrushError, OSError) as error:
                # The database is unavailable; the tokens were valid at the last check.
                log.info("tokens of open sockets are checked later: %s", error)

    async def _check_one(self, sessions: dict[ViewerSession, WebSocket]) -> None:
        socket = next(iter(sessions.values()), None)
        if socket is None:  # closed since this check began
            return
        try:
            await self._check(socket)
        except UnauthorizedError:
            for session in list(sessions):
                session.expel()
