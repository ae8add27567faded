"""Closing of stalled HTTP connections, which uvicorn itself would keep.

Some clients never finish a request's headers, some never read their answer.  Connections above the
limit of open files are refused with an answer, so that the other connections keep working.
"""

from __future__ import annotations

import asyncio
from typing import Any

from starlette.types import Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from pointbrush.system.resources import most_connections
from pointbrush.web.problems import problem

HEARD_OUT = 32
"""Connections above the limit that get an answer; further ones are closed at once."""
REFUSED_SECONDS = 2.0
"""Time in which a connection above the limit must send a request to get an answer."""


async def too_many_connections(scope: Scope, receive: Receive, send: Send) -> None:
    """Answer any request with a refusal; an ASGI application."""
    detail = "the server has reached its limit of connections; try again later"
    headers = {"Connection": "close"}
    await problem(503, detail, "Temporarily unavailable", headers)(scope, receive, send)


class IdleTimeoutProtocol(H11Protocol):
    """Waits ``seconds`` for the headers of a request, however slowly their bytes come in."""

    seconds = 20.0
    stall_seconds = 60.0
    """Longest time that a client may leave an answer unread."""
    _stall: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Start waiting for the first request."""
        super().connection_made(transport)
        too_many = len(self.connections) - most_connections()
        if too_many > HEARD_OUT:
            self.transport.abort()
        elif too_many > 0:
            self.app = too_many_connections
            self.seconds = REFUSED_SECONDS
        self._wait()

    def _should_upgrade(self) -> bool:
        return self.app is not too_many_connections and bool(super()._should_upgrade())

    def _wait(self) -> None:
        self.loop.call_later(self.seconds, self._look, self.scope)

    def _look(self, before: Any) -> None:
        # An upgraded connection belongs to the WebSocket's protocol, which has timeouts.
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            return
        # There is no cycle before the first request.
        serving = not getattr(self.cycle, "response_complete", True)
        if self.scope is before and not serving:
            self.transport.close()
        else:
            self._wait()

    def pause_writing(self) -> None:
        """Abort the connection unless the client reads on in time."""
        super().pause_writing()
        self._stall = self.loop.call_later(self.stall_seconds, self.transport.abort)

    def resume_writing(self) -> None:
        """End the timeout when the client reads again."""
        self._end_stall()
        super().resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        """End the timeouts of a closed connection."""
        self._end_stall()
        super().connection_lost(exc)

    def _end_stall(self) -> None:
        if self._stall is not None:
            self._stall.cancel()
            self._stall = None


def idle_timeout_protocol(stall_seconds: float) -> type[IdleTimeoutProtocol]:
    """Return the protocol for uvicorn, which makes its connections by calling a class."""
    return type("IdleTimeoutProtocol", (IdleTimeoutProtocol,), {"stall_seconds": stall_seconds})
