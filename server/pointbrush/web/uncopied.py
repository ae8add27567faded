"""WebSocket connections whose messages are not copied on their way out.

uvicorn copies each message behind its header; for a frame of a megabyte that copy costs a quarter
of what sending costs in all.
"""

from __future__ import annotations

import struct
from collections.abc import MutableMapping
from typing import Any

from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.protocol import State

BINARY = 0x82
"""A whole message of bytes (RFC 6455, section 5.2)."""


class UncopiedProtocol(WebSocketsSansIOProtocol):
    """Hands header and message to the transport as they are; everything else is uvicorn's."""

    async def send(self, message: MutableMapping[str, Any]) -> None:  # type: ignore[override]
        """An ASGI event; raises ClientDisconnected once the client has gone."""
        data = message.get("bytes")
        if data is None or self.conn.state is not State.OPEN or self.conn.extensions:
            await super().send(message)  # type: ignore[arg-type]
            return
        await self.writable.wait()
        if self.disconnected or self.close_sent:
            raise ClientDisconnected
        self.transport.writelines((header(len(data)), data))

    def shutdown(self) -> None:
        """The server stops.  Who is about to leave anyway is told nothing more."""
        if self.handshake_complete and self.conn.state is not State.OPEN:
            # uvicorn would send its close frame behind the one that answered the client's, which
            # the protocol refuses: the whole server would end with an error.
            self.stop_keepalive()
            self.transport.close()
            return
        super().shutdown()


def header(length: int) -> bytes:
    """What goes ahead of ``length`` bytes from a server: unmasked, in one piece."""
    if length < 126:
        return bytes((BINARY, length))
    if length < 65536:
        return struct.pack("!BBH", BINARY, 126, length)
    return struct.pack("!BBQ", BINARY, 127, length)
