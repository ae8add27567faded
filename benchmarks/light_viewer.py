"""A viewer that costs next to nothing: it notes when frames come, and gives credits.

A hundred of these fit beside the server on two cores; a client that decodes would be what is
measured.
"""

from __future__ import annotations

import asyncio
import base64
import os
import time
from typing import TypeVar

import msgpack
from bare_websocket import PROTOCOL as BARE

from pointbrush.streaming.schema import subprotocol

PEEK = 96
"""Bytes of a message that are looked at: its type, and a frame's number."""
FORGET_EVERY = 24
POINTS = (b"\xa4type\xa5frame", b"\xa4type\xa5depth")
"""Beginnings of the messages that bring points."""


class LightViewer(asyncio.Protocol):
    """One socket; ``arrivals`` holds time, frame and bytes of each frame message."""

    protocol = subprotocol()
    peek = PEEK

    def __init__(self, host: str, token: str) -> None:
        self.arrivals: list[tuple[float, int, int]] = []
        self.nbytes = 0
        self.started = 0.0
        self.lost = asyncio.get_running_loop().create_future()
        self._host, self._token = host, token
        self._buffer = bytearray()
        self._skip = 0
        self._shaken = False
        self._saying: bytearray | None = None
        self._forgotten: list[int] = []

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        key = base64.b64encode(os.urandom(16)).decode()
        transport.write(
            f"GET /api/v1/stream HTTP/1.1\r\nHost: {self._host}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n"
            f"Sec-WebSocket-Protocol: {self.protocol}\r\n"
            f"Authorization: Bearer {self._token}\r\n\r\n".encode()
        )

    def connection_lost(self, exc: Exception | None) -> None:
        if not self.lost.done():
            self.lost.set_result(exc)

    def data_received(self, data: bytes) -> None:
        if not self._shaken:
            self._buffer += data
            head, found, rest = self._buffer.partition(b"\r\n\r\n")
            if not found:
                return
            assert b" 101 " in head, head
            self._shaken, self._buffer, data = True, bytearray(), bytes(rest)
        if self._skip >= len(data):
            self._skip -= len(data)
            return
        self._buffer += memoryview(data)[self._skip :]
        self._skip = 0
        self._saying = bytearray()
        while self._message():
            pass
        # All that there is to say to what came in one piece leaves in one.
        if self._saying:
            self._transport.write(self._saying)
        self._saying = None

    def _message(self) -> bool:
        buffer = self._buffer
        if len(buffer) < 10:
            return False
        length, start = buffer[1] & 127, 2
        if length == 126:
            length, start = int.from_bytes(buffer[2:4], "big"), 4
        elif length == 127:
            length, start = int.from_bytes(buffer[2:10], "big"), 10
        if len(buffer) < start + min(length, self.peek):
            return False
        self._seen(bytes(buffer[start : start + min(length, self.peek)]), length)
        self._skip = max(0, start + length - len(buffer))
        del buffer[: start + length]
        return self._skip == 0

    def _seen(self, peek: bytes, length: int) -> None:
        if not any(kind in peek[:16] for kind in POINTS):
            return
        unpacker = msgpack.Unpacker(max_buffer_size=self.peek)
        unpacker.feed(peek)
        unpacker.read_map_header()
        # type, sequence, frame, total and final come first.
        head = {unpacker.unpack(): unpacker.unpack() for _ in range(5)}
        self.nbytes += length
        self.frame(head["frame"], head["final"], length)

    def frame(self, number: int, _final: bool, length: int) -> None:
        """A frame message came: give its credit, and drop the frame so that it comes again."""
        self.arrivals.append((time.monotonic(), number, length))
        self.send(type="credit", frames=1, nbytes=length)
        self._forgotten.append(number)
        self._forget()

    def _forget(self) -> None:
        if len(self._forgotten) >= FORGET_EVERY:
            self.send(type="forget", frames=self._forgotten)
            self._forgotten = []

    def send(self, **message: object) -> None:
        """Send one message, masked with zeros."""
        data: bytes = msgpack.packb(message)
        small = len(data) < 126
        size = bytes([128 | len(data)]) if small else b"\xfe" + len(data).to_bytes(2, "big")
        whole = b"\x82" + size + b"\0\0\0\0" + data
        if self._saying is None:
            self._transport.write(whole)
        else:
            self._saying += whole

    def stop_reading(self) -> None:
        """Let everything wait at the server."""
        self._transport.pause_reading()

    def close(self) -> None:
        """Drop the connection."""
        self._transport.abort()


class Puller(LightViewer):
    """Asks for the next frame as soon as one is complete."""

    def __init__(self, host: str, token: str) -> None:
        super().__init__(host, token)
        self.frames = self.done = self._wanted = 0
        self._complete: set[int] = set()

    def frame(self, number: int, final: bool, length: int) -> None:
        self.send(type="credit", frames=1, nbytes=length)
        if final:
            self._complete.add(number)
        while self._wanted in self._complete:
            self._complete.discard(self._wanted)
            self._forgotten.append(self._wanted)
            self._wanted, self.done = (self._wanted + 1) % self.frames, self.done + 1
            self.send(type="seek", frame=self._wanted)
        self._forget()


class Drinker(LightViewer):
    """Takes what a bare socket pushes at it, and says nothing."""

    protocol = BARE

    def frame(self, _number: int, _final: bool, _length: int) -> None:
        """Only the bytes count."""


Light = TypeVar("Light", bound=LightViewer)


async def connect_light(kind: type[Light], url: str, token: str) -> Light:
    """A connected light viewer."""
    host = url.removeprefix("http://")
    name, port = host.split(":")
    loop = asyncio.get_running_loop()
    _, protocol = await loop.create_connection(lambda: kind(host, token), name, int(port))
    while not protocol._shaken:
        await asyncio.sleep(0.005)
    return protocol
