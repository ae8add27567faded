"""WebSocket connections: what they write, and how they end."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any
from unittest.mock import MagicMock

import pytest
import uvicorn
from hypothesis import given
from hypothesis import strategies as st
from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.server import ServerState
from websockets.frames import Frame, Opcode
from websockets.protocol import State

from pointbrush.web.server import listen
from pointbrush.web.websocket_protocol import AT_ONCE, BINARY, EXTENSION, WebSocketProtocol, header
from tests.waiting import PATIENCE, comes_true

HELLO = (
    b"GET / HTTP/1.1\r\nHost: here\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
GOODBYE = Frame(Opcode.CLOSE, b"").serialize(mask=True)


@pytest.mark.parametrize("length", [0, 1, 125, 126, 65_535, 65_536, 2**20])
def test_what_goes_ahead_is_what_the_library_would_write(length: int) -> None:
    data = bytes(length)
    assert header(length) + data == Frame(Opcode.BINARY, data).serialize(mask=False)


def written(opcode: Opcode, data: bytes, *, fin: bool = True) -> bytes:
    return Frame(opcode, data, fin=fin).serialize(mask=True)


TURNS = 300
"""Of the event loop, in which an application takes all that was fed to it."""


@contextmanager
def connected(
    taken: Callable[[bytes], bool], **options: Any
) -> Iterator[tuple[Callable[[bytes, int], None], list[bytes], MagicMock]]:
    """A protocol whose handshake is done; yields how to feed it and what came by ASGI."""
    messages: list[bytes] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        assert (await receive())["type"] == "websocket.connect"
        await send({"type": "websocket.accept"})
        link = scope["extensions"][EXTENSION]["link"]
        link.on_message = taken
        while (event := await receive())["type"] == "websocket.receive":
            messages.append(event.get("bytes") or event["text"].encode())
        messages.append(b"end")

    transport = MagicMock()
    transport.is_closing.return_value = False
    loop = asyncio.new_event_loop()
    config = uvicorn.Config(app, ws=WebSocketProtocol, ws_ping_interval=None, **options)
    config.load()
    state = ServerState()

    async def feed(data: bytes, size: int) -> None:
        for at in range(0, len(data), size):
            link.data_received(data[at : at + size])
        for _ in range(TURNS):
            await asyncio.sleep(0)

    try:
        link = WebSocketProtocol(config, state, {}, loop)
        link.connection_made(transport)
        loop.run_until_complete(feed(HELLO, len(HELLO)))
        yield lambda data, size: loop.run_until_complete(feed(data, size)), messages, transport
    finally:
        link.connection_lost(None)
        loop.run_until_complete(asyncio.sleep(0))
        loop.close()


def taker(heard: list[bytes]) -> Callable[[bytes], bool]:
    """Takes every message at once."""

    def take(message: bytes) -> bool:
        heard.append(message)
        return True

    return take


@given(
    kinds=st.lists(st.sampled_from(["short", "long", "parts", "ping", "late"]), max_size=30),
    size=st.integers(1, 400),
)
def test_every_message_comes_once_and_in_order_however_it_is_cut(
    kinds: list[str], size: int
) -> None:
    stream, sent = b"", []
    for number, kind in enumerate(kinds):
        body = f"{kind} {number} ".encode() * (60 if kind == "long" else 1)
        if kind == "parts":
            stream += written(Opcode.BINARY, body[:3], fin=False) + written(Opcode.PING, b"in it")
            stream += written(Opcode.CONT, b"", fin=False) + written(Opcode.CONT, body[3:])
        elif kind == "ping":
            stream += written(Opcode.PING, body)
            continue
        else:
            stream += written(Opcode.BINARY, body)
        sent.append(body)
    came: list[bytes] = []

    def on_message(message: bytes) -> bool:
        came.extend(messages)
        messages.clear()
        if message.startswith(b"late"):
            return False
        came.append(message)
        return True

    with connected(on_message) as (feed, messages, _):
        feed(stream, size)
        assert came + messages == sent


def test_what_the_protocol_forbids_ends_the_connection() -> None:
    short = written(Opcode.BINARY, b"ok")
    for wrong in (
        Frame(Opcode.BINARY, b"unmasked").serialize(mask=False),
        written(Opcode.BINARY, bytes(2000)),
        written(Opcode.BINARY, b"a", fin=False) + short,
        written(Opcode.CONT, b"of nothing"),
        bytes([BINARY | 0x40]) + short[1:],
    ):
        heard: list[bytes] = []
        with connected(taker(heard), ws_max_size=1000) as (
            feed,
            messages,
            transport,
        ):
            feed(short + wrong + short, 10_000)
            feed(short, 10_000)
        assert heard == [b"ok"], wrong[:20]
        assert messages == [b"end"]
        assert transport.close.called


def test_many_messages_in_one_piece_are_not_heard_in_one_turn() -> None:
    heard: list[bytes] = []
    with connected(taker(heard)) as (feed, messages, transport):
        feed(b"".join(written(Opcode.BINARY, b"%d" % i) for i in range(100)), 100_000)
        assert len(heard) == AT_ONCE
        assert transport.pause_reading.called
        assert heard + messages == [b"%d" % i for i in range(100)]


@pytest.mark.parametrize("why", ["not read", "just heard", "gone"])
def test_who_is_not_read_or_was_just_heard_is_not_taken_for_gone(why: str) -> None:
    loop = asyncio.new_event_loop()
    config = uvicorn.Config(lambda: None, ws=WebSocketProtocol, ws_ping_timeout=20)  # type: ignore[arg-type]
    config.load()
    link = WebSocketProtocol(config, ServerState(), {}, loop)
    link.transport = transport = MagicMock()
    transport.is_closing.return_value = False
    link.read_paused = why == "not read"
    if why == "just heard":
        link._received_at = loop.time()
    link.keepalive_timeout()
    assert transport.close.called == (why == "gone")
    assert (link.pong_timer is None) == (why == "gone"), "it is looked at again"
    link.stop_keepalive()
    loop.close()


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
            flood, ws=WebSocketProtocol, lifespan="off", timeout_graceful_shutdown=1
        )
        server = uvicorn.Server(config)
        serving = asyncio.create_task(server.serve([listener]))
        await comes_true(lambda: server.started)
        reader, writer = await asyncio.open_connection(*listener.getsockname())
        writer.write(HELLO)
        await reader.readuntil(b"\r\n\r\n")
        writer.write(GOODBYE)
        await comes_true(
            lambda: (
                not any(
                    isinstance(c, WebSocketProtocol) and c.conn.state is State.OPEN
                    for c in server.server_state.connections
                )
            )
        )
        assert server.server_state.connections, "what was sent waits to be read"
        server.should_exit = True
        await asyncio.wait_for(serving, PATIENCE)
        writer.close()
        with suppress(ConnectionError):
            await writer.wait_closed()

    asyncio.run(scenario())
