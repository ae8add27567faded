"""WebSocket connections: what they write, and how they end."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import Any

import pytest
import uvicorn
from uvicorn.protocols.utils import ClientDisconnected
from websockets.frames import Frame, Opcode
from websockets.protocol import State

from pointbrush.web.server import listen
from pointbrush.web.uncopied import UncopiedProtocol, header

HELLO = (
    b"GET / HTTP/1.1\r\nHost: here\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
GOODBYE = Frame(Opcode.CLOSE, b"").serialize(mask=True)


@pytest.mark.parametrize("length", [0, 1, 125, 126, 65_535, 65_536, 2**20])
def test_what_goes_ahead_is_what_the_library_would_write(length: int) -> None:
    data = bytes(length)
    assert header(length) + data == Frame(Opcode.BINARY, data).serialize(mask=False)


def test_a_server_stops_in_peace_while_a_client_that_does_not_read_is_leaving() -> None:
    async def flood(scope: Any, receive: Any, send: Any) -> None:
        assert scope["type"] == "websocket"
        await receive()
        await send({"type": "websocket.accept"})
        with suppress(ClientDisconnected):
            while True:
                await send({"type": "websocket.send", "bytes": bytes(2**20)})

    async def scenario() -> None:
        listener = listen("127.0.0.1", 0)
        config = uvicorn.Config(
            flood, ws=UncopiedProtocol, lifespan="off", timeout_graceful_shutdown=1
        )
        server = uvicorn.Server(config)
        serving = asyncio.create_task(server.serve([listener]))
        while not server.started:
            await asyncio.sleep(0.01)
        reader, writer = await asyncio.open_connection(*listener.getsockname())
        writer.write(HELLO)
        await reader.readuntil(b"\r\n\r\n")
        writer.write(GOODBYE)
        while any(
            isinstance(c, UncopiedProtocol) and c.conn.state is State.OPEN
            for c in server.server_state.connections
        ):
            await asyncio.sleep(0.01)
        assert server.server_state.connections, "what was sent waits to be read"
        server.should_exit = True
        await asyncio.wait_for(serving, 20)
        writer.close()
        with suppress(ConnectionError):
            await writer.wait_closed()

    asyncio.run(scenario())
