"""The WebSocket: admits a caller, then passes bytes to and from its session."""

from __future__ import annotations

import logging

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketDisconnect
from uvicorn.protocols.utils import ClientDisconnected

from pointbrush.accounts.roles import require
from pointbrush.errors import ForbiddenError, PointbrushError, UnauthorizedError
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.schema import subprotocol
from pointbrush.streaming.session import Admitted, ViewerSession
from pointbrush.system.resources import shortage
from pointbrush.web.problems import problem_of
from pointbrush.web.security.admissions import Admissions
from pointbrush.web.security.auth import Gate, Principal
from pointbrush.web.security.roles import PREFIX
from pointbrush.web.websocket_protocol import WebSocketProtocol, link_of

log = logging.getLogger(__name__)
router = APIRouter(prefix=PREFIX)
TEXT_REFUSED = 1003
GOING_AWAY = 1001
TRY_AGAIN_LATER = 1013
MOST_REASON = 120
"""Characters of the reason of a close; the protocol has room for 123 bytes."""
NOT_ADMITTED = 4401
CLOSE_SECONDS = 2.0
"""Longest wait for a client's answer to a close; then the connection is aborted."""


@router.websocket("/stream")
async def stream(socket: WebSocket) -> None:
    """Serve one viewer, from its handshake to its end.

    A client that disconnects during the handshake raises ClientDisconnected, which uvicorn does
    not log.
    """
    hub: Hub = socket.app.state.hub
    try:
        principal = await hub.read(admit, socket)
    except PointbrushError as error:
        await socket.send_denial_response(problem_of(error))
        return
    await socket.accept(subprotocol=subprotocol())
    await serve(socket, hub, principal)


def admit(socket: WebSocket) -> Principal:
    """Return the caller; raise UnauthorizedError, or ForbiddenError for a stale page or origin."""
    gate: Gate = socket.app.state.gate
    gate.require_host(socket)
    principal = gate.admit(socket)
    require(principal.role, "viewer")
    offered = socket.scope["subprotocols"]
    if subprotocol() not in offered:
        raise ForbiddenError(f"subprotocol: expected {subprotocol()}, got {', '.join(offered)!r}")
    return principal


async def serve(socket: WebSocket, hub: Hub, principal: Principal) -> None:
    """Run the viewer's session over an accepted socket."""
    link = link_of(socket)
    gate: Gate = socket.app.state.gate
    session = ViewerSession(
        hub,
        link.deliver,
        Admitted(
            principal.author,
            principal.name,
            principal.role,
            principal.shared,
            require_admitted=lambda: still_admitted(socket, principal),
            role_in=lambda sequence: gate.role_in(principal, sequence),
            sees=lambda job: gate.may_see_job(principal, job),
        ),
        send_each=link.deliver_each,
    )

    async def receive() -> bytes | None:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            return None
        data: bytes | None = message.get("bytes")
        if data is None:
            await socket.close(TEXT_REFUSED, "expected binary messages, got text")
        return data

    link.on_message = session.on_message
    admissions: Admissions = socket.app.state.admissions
    try:
        with admissions.watching(socket, session):
            await session.run(receive)
        if session.expelled:
            await expel(socket, link)
        elif session.closing.is_set():
            await socket.close(GOING_AWAY, "the server is stopping, connect again")
    except (WebSocketDisconnect, ClientDisconnected):
        return
    except (OSError, MemoryError, RuntimeError, ImportError) as error:
        if (short := shortage(error)) is None:
            raise
        log.warning("a viewer is sent away: %s", short)
        await socket.close(TRY_AGAIN_LATER, str(short)[:MOST_REASON])


async def expel(socket: WebSocket, link: WebSocketProtocol) -> None:
    """Close the socket of a caller without a valid token, even if the caller does not read."""
    link.loop.call_later(CLOSE_SECONDS, link.transport.abort)
    await socket.close(NOT_ADMITTED, "expected a valid token, it was revoked or has expired")


def still_admitted(socket: WebSocket, principal: Principal) -> None:
    """Raise UnauthorizedError once the token or session of an open socket is not valid."""
    now = admit(socket)
    if (now.author, now.role) != (principal.author, principal.role):
        raise UnauthorizedError("expected the token that this socket was opened with")
