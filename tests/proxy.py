"""A reverse proxy such as Caddy for tests: a server by a cookie, and who the client is."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

OURS = (b"x-forwarded-for", b"x-forwarded-proto", b"connection", b"keep-alive")
"""Headers that clients do not get through."""
STICKY = b"pointbrush_server="


@contextmanager
def proxy(ports: Sequence[int]) -> Iterator[str]:
    """Serve what listens on ``ports`` of loopback at the address that is given.

    The cookie ``pointbrush_server`` has the number of the server, else the first one answers.  The
    servers are told that clients speak HTTPS.  Each connection carries one request, or a socket.
    """
    loop, ready = asyncio.new_event_loop(), threading.Event()
    found: list[int] = []

    async def serve() -> None:
        async with await asyncio.start_server(
            lambda reader, writer: _carry(reader, writer, ports), "127.0.0.1", 0
        ) as server:
            found.append(server.sockets[0].getsockname()[1])
            ready.set()
            with suppress(asyncio.CancelledError):
                await server.serve_forever()

    task = loop.create_task(serve())
    thread = threading.Thread(target=loop.run_until_complete, args=(task,), daemon=True)
    thread.start()
    assert ready.wait(10)
    try:
        yield f"http://127.0.0.1:{found[0]}"
    finally:
        loop.call_soon_threadsafe(task.cancel)
        thread.join(10)
        for each in asyncio.all_tasks(loop):
            each.cancel()
            with suppress(asyncio.CancelledError):
                loop.run_until_complete(each)
        loop.close()


async def _carry(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter, ports: Sequence[int]
) -> None:
    """Hand one request on, and the bytes of both sides until one ends."""
    try:
        head = (await reader.readuntil(b"\r\n\r\n"))[:-4].split(b"\r\n")
        there, back = await asyncio.open_connection("127.0.0.1", ports[_number(head)])
    except (OSError, asyncio.IncompleteReadError):
        writer.close()
        return
    socket = any(line.lower().startswith(b"upgrade:") for line in head)
    kept = [line for line in head if line.partition(b":")[0].lower() not in OURS]
    kept += [b"X-Forwarded-For: " + writer.get_extra_info("peername")[0].encode()]
    kept += [b"X-Forwarded-Proto: https", b"Connection: " + (b"Upgrade" if socket else b"close")]
    back.write(b"\r\n".join(kept) + b"\r\n\r\n")
    asked = asyncio.create_task(_pump(reader, back))
    await _pump(there, writer)
    asked.cancel()
    for end in (writer, back):
        end.close()


def _number(head: Sequence[bytes]) -> int:
    cookies = b";".join(line for line in head if line.lower().startswith(b"cookie:"))
    return int(cookies.partition(STICKY)[2][:1] or b"0")


async def _pump(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with suppress(OSError):
        while data := await reader.read(1 << 16):
            writer.write(data)
            await writer.drain()
