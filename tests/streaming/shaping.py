"""A poor link: a proxy that lets bytes from the server through at a given rate."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

BUFFER = 64 * 1024
"""Bytes that the link itself may hold, as a router would."""


class Link:
    """Bits a second, which may change while it runs."""

    def __init__(self, bits: float) -> None:
        self.bits = bits


@asynccontextmanager
async def shaped(url: str, bits: float | Link) -> AsyncIterator[str]:
    """The URL of a proxy in front of ``url`` with ``bits`` a second downward."""
    link = bits if isinstance(bits, Link) else Link(bits)
    host, port = url.removeprefix("http://").split(":")
    tasks: set[asyncio.Task[None]] = set()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        raw = socket.socket()
        # Small kernel buffers, so that the rate is the link's and not a buffer's.
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
        raw.setblocking(False)
        await asyncio.get_running_loop().sock_connect(raw, (host, int(port)))
        up, down = await asyncio.open_connection(sock=raw, limit=BUFFER)
        for task in (pump(reader, down, None), pump(up, writer, link)):
            running = asyncio.ensure_future(task)
            tasks.add(running)
            running.add_done_callback(tasks.discard)

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    try:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
    finally:
        server.close()
        for task in list(tasks):
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def pump(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter, link: Link | None
) -> None:
    """Copy until either end closes."""
    loop = asyncio.get_running_loop()
    free = loop.time()
    try:
        while data := await reader.read(8192 if link else BUFFER):
            if link is not None:
                free = max(free, loop.time()) + len(data) * 8 / link.bits
                if free > loop.time() + 0.002:
                    await asyncio.sleep(free - loop.time())
            writer.write(data)
            await writer.drain()
    except OSError:
        pass  # the other end has gone; so does this one
    finally:
        with contextlib.suppress(OSError):
            writer.close()
