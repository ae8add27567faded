"""The WebSocket: admits a caller, then hands bytes to and from its session."""

from __future__ import annotations

from fastapi import APIRouter, WebSocket
from starlette.websockets import WebSocketDisconnect

from pointbrush.errors import ForbiddenError, PointbrushError
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.schema import subprotocol
from pointbrush.streaming.session import ViewerSession
from pointbrush.web.auth import Gate, Principal
from pointbrush.web.problems import problem_of

router = APIRouter()
TEXT_REFUSED = 1003
GOING_AWAY = 1001


@router.websocket("/stream")
async def stream(socket: WebSocket) -> None:
    """One viewer, from its handshake to its end."""
    try:
        principal = admit(socket)
    except PointbrushError as error:
        await socket.send_denial_response(problem_of(error))
        return
    await socket.accept(subprotocol=subprotocol())
    await serve(socket, principal)


def admit(socket: WebSocket) -> Principal:
    """The caller; raises UnauthorizedError, or ForbiddenError for a stale page or origin."""
    gate: Gate = socket.app.state.gate
    gate.require_host(socket)
    principal = gate.admit(socket)
    offered = socket.scope["subprotocols"]
    if subprotocol() not in offered:
        raise ForbiddenError(f"subprotocol: expected {subprotocol()}, got {', '.join(offered)!r}")
    return principal


async def serve(socket: WebSocket, principal: Principal) -> None:
    """Run the viewer's session over an accepted socket."""
    hub: Hub = socket.app.state.hub
    session = ViewerSession(
        hub,
        # Starlette's own send_bytes checks the state again at each message; it is known here.
        lambda data: socket.send({"type": "websocket.send", "bytes": data}),
        author=principal.author,
        role=principal.role,
        shared=principal.shared,
    )

    async def receive() -> bytes | None:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            return None
        data: bytes | None = message.get("bytes")
        if data is None:
            await socket.close(TEXT_REFUSED, "expected binary messages, got text")
        return data

    try:
        await session.run(receive)
        if session.closing.is_set():
            await socket.close(GOING_AWAY, "the server is stopping")
    except WebSocketDisconnect:
        return
