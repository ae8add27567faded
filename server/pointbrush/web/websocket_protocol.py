"""WebSocket connections with low cost for each message.

uvicorn copies each message after its header; for a frame of a megabyte this copy takes a quarter of
the time of sending.  Each received message passes a parser made of generators, a queue, a task, and
two system calls that pause and resume reading: for the credits of a hundred viewers, this takes as
long as sending their frames.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, MutableMapping, Sequence
from typing import Any

from starlette.websockets import WebSocket
from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.http11 import Request
from websockets.protocol import State

try:
    from websockets.speedups import apply_mask
except ImportError:  # a build without compiled parts
    from websockets.utils import apply_mask

BINARY = 0x82
"""A whole message of bytes (RFC 6455, section 5.2)."""
MASKED = 0x80
AT_ONCE = 8
"""Messages of one read that are handled at once; further ones wait in uvicorn's queue."""
EXTENSION = "pointbrush.link"


class WebSocketProtocol(WebSocketsSansIOProtocol):
    """Handles whole messages of bytes without uvicorn, in order; uvicorn handles the others."""

    on_message: Callable[[bytes], bool] | None = None
    """Handles a message and returns True, or returns False to pass it to ASGI's ``receive``."""
    _tail = b""
    """The beginning of a frame with an incomplete head."""
    _received_at = float("-inf")
    """Time at which data was last received."""
    _owed = 0
    """Remaining bytes of a frame that the library reads."""

    def handle_connect(self, event: Request) -> None:
        """Put this connection into the scope's extensions, for the application."""
        super().handle_connect(event)
        if self.handshake_initiated and not self.handshake_complete:
            self.scope["extensions"][EXTENSION] = {"link": self}

    # ── received data ────────────────────────────────────────────────────────────────────

    def keepalive_timeout(self) -> None:
        """Close the connection without a pong unless data arrived lately or reading is paused."""
        patience = self.ping_timeout or 0.0
        if self.read_paused or self.loop.time() - self._received_at < patience:
            self.pong_timer = self.loop.call_later(patience, self.keepalive_timeout)
            return
        super().keepalive_timeout()

    def data_received(self, data: bytes) -> None:
        """Split received data into frames; handle short whole messages without the library."""
        self._received_at = self.loop.time()
        if self.on_message is None:
            super().data_received(data)
            return
        if self._tail:
            data, self._tail = self._tail + data, b""
        at, left = 0, AT_ONCE
        while at < len(data):
            if not self._owed:
                body, length = body_of(data, at)
                if not body:
                    self._tail = data[at:]
                    return
                end = body + length
                if end <= len(data) and self._simple(data, at, length):
                    left -= self._handle_or_queue(
                        apply_mask(data[body:end], data[body - 4 : body]), left
                    )
                    at = end
                    continue
                self._owed = end - at
            part = data[at : at + self._owed]
            self._owed -= len(part)
            at += len(part)
            super().data_received(part)

    def _simple(self, data: bytes, at: int, length: int) -> bool:
        """Return whether the frame is a whole message that a client may send now."""
        return (
            data[at] == BINARY
            and data[at + 1] >= MASKED
            and not self.frames
            and self.conn.state is State.OPEN
            and length <= self.config.ws_max_size
        )

    def _handle_or_queue(self, message: bytes, left: int) -> bool:
        """Handle a message now, or append it to uvicorn's queue; return whether it was handled."""
        handled = (
            self.on_message is not None
            and left > 0
            and self.queue.empty()
            and self.on_message(message)
        )
        if not handled:
            self.curr_msg_data_type, self.frames = "bytes", [message]
            self.send_receive_event_to_app()
        return handled

    # ── sent data ────────────────────────────────────────────────────────────────────────

    async def send(self, message: MutableMapping[str, Any]) -> None:  # type: ignore[override]
        """Send an ASGI event; raise ClientDisconnected after the client has disconnected."""
        data = message.get("bytes")
        if data is None or self.conn.state is not State.OPEN or self.conn.extensions:
            await super().send(message)  # type: ignore[arg-type]
            if self.initial_response is not None and self.close_sent:
                # The app refused the handshake properly: uvicorn would log an error of the app.
                self.handshake_complete = True
            return
        await self.deliver(data)

    async def deliver(self, *parts: bytes | memoryview, before: bytes | None = None) -> None:
        """Send a message of bytes; raise ClientDisconnected after the client has disconnected.

        A part may be a view of a mapped file: the system reads it when the socket takes it.
        ``before``: a message to send ahead of it, in the same write.
        """
        await self._room()
        ahead = () if before is None else (header(len(before)), before)
        pieces = (*ahead, header(sum(map(len, parts))), *parts)
        if self.scheme == "wss":
            # TLS reads the parts later in this process, which would end if a mapped file had been
            # truncated; without TLS, the system only closes the connection.
            self.transport.write(b"".join(pieces))
            return
        self.transport.writelines(pieces)

    async def deliver_each(self, messages: Sequence[bytes]) -> None:
        """Send messages of bytes in one write; raise ClientDisconnected as ``deliver``."""
        if messages:
            await self._room()
            parts = (part for data in messages for part in (header(len(data)), data))
            self.transport.write(b"".join(parts))

    async def _room(self) -> None:
        if not self.writable.is_set():
            await self.writable.wait()
        if self.disconnected or self.close_sent or self.conn.state is not State.OPEN:
            raise ClientDisconnected

    def shutdown(self) -> None:
        """Close the connection when the server stops, without a close frame if it is closing."""
        if self.handshake_complete and self.conn.state is not State.OPEN:
            # uvicorn would send a close frame after the answer to the client's close frame, which
            # the protocol forbids: the whole server would end with an error.
            self.stop_keepalive()
            self.transport.close()
            return
        super().shutdown()


def link_of(socket: WebSocket) -> WebSocketProtocol:
    """Return the connection of a socket that this module's protocol serves."""
    link: WebSocketProtocol = socket.scope["extensions"][EXTENSION]["link"]
    return link


def header(length: int) -> bytes:
    """Return the head of ``length`` bytes from a server: unmasked, in one piece."""
    if length < 126:
        return bytes((BINARY, length))
    if length < 65536:
        return struct.pack("!BBH", BINARY, 126, length)
    return struct.pack("!BBQ", BINARY, 127, length)


def body_of(data: bytes, at: int) -> tuple[int, int]:
    """Return offset and length of the body of the frame at ``at``; (0, 0): incomplete head."""
    if len(data) < at + 2:
        return 0, 0
    length, body = data[at + 1] & 0x7F, at + 2
    if length >= 126:
        size = 2 if length == 126 else 8
        length, body = int.from_bytes(data[body : body + size], "big"), body + size
    if data[at + 1] >= MASKED:
        body += 4
    return (body, length) if len(data) >= body else (0, 0)
