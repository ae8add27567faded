"""Hundreds of connections at once: strangers during an import, and viewers that never read."""

from __future__ import annotations

import base64
import os
import resource
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import msgpack
from websockets.frames import Frame, Opcode

from pointbrush.streaming.schema import subprotocol
from tests.faults.clients import SEQUENCE
from tests.faults.server import TOKEN, ServerProcess, running
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, Tally, scenario
from tests.torture.librarian import Librarian
from tests.torture.machine import resident

CONNECTIONS, DEAF = 1500, 200
FAR = 120.0
MOST_BYTES = 2 << 20
"""Memory that a viewer who never reads may take."""


@contextmanager
def many_files() -> Iterator[None]:
    """This process may open as many files as it ever may, until the context ends."""
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (before[1], before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)


def connected(server: ServerProcess, *, window: int = 0) -> socket.socket:
    """Connect to a server; ``window``: bytes that wait for this reader, 0 as the system says."""
    link = socket.socket()
    link.settimeout(FAR)
    if window:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, window)
    link.connect(("127.0.0.1", server.port))
    return link


@scenario("1,500 connections at once, during imports and edits of six authors", 1)
def connections(arena: Arena) -> None:
    """Each asks for the server's health and stays: 200, or 503 in words when there are too many."""
    authors, librarian = Authors(arena.folder / "workspace", arena.seed), Librarian(arena, 200_000)
    server = arena.stack.enter_context(running(arena.folder / "workspace"))
    arena.stack.enter_context(many_files())
    for _ in arena.rounds():
        with (
            authors.editing(lambda: [server.url]),
            librarian.importing(lambda: server.url),
            ExitStack() as held,
        ):
            time.sleep(arena.rng.uniform(0.0, 1.0))
            links = [held.enter_context(connected(server)) for _ in range(CONNECTIONS)]
            for link in links:
                link.sendall(b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
            for link in links:
                _answered(link, arena.tally)
        authors.settle(server, arena.tally)
        librarian.settle(server)
    quiet(server, arena.tally)


def _answered(link: socket.socket, tally: Tally) -> None:
    answer = link.recv(4096).decode()
    status = int(answer.split()[1]) if answer else 0
    if status not in (200, 503):
        tally.count("errors", f"a connection was answered {answer!r}")
    tally.status(status, answer, away=True)


@scenario("200 viewers play without reading, while six authors edit", 1)
def deaf_viewers(arena: Arena) -> None:
    """Authors go on, and each viewer takes a bounded part of the server's memory."""
    authors = Authors(arena.folder / "workspace", arena.seed)
    server = arena.stack.enter_context(running(arena.folder / "workspace"))
    for _ in arena.rounds():
        before = resident(server.process.pid)
        with authors.editing(lambda: [server.url]), ExitStack() as held:
            for _ in range(DEAF):
                held.enter_context(_deaf(server))
            time.sleep(min(arena.rest(), 5.0))
            grown = resident(server.process.pid) - before
        if grown > DEAF * MOST_BYTES:
            arena.tally.count("differs", f"{DEAF} viewers who never read take {grown:,} bytes")
        authors.settle(server, arena.tally)
    quiet(server, arena.tally)


def _deaf(server: ServerProcess) -> socket.socket:
    """A viewer who has read nothing but the answer to the handshake."""
    link = connected(server, window=4096)
    key = base64.b64encode(os.urandom(16)).decode()
    lines = (
        "GET /api/v1/stream HTTP/1.1", f"Host: 127.0.0.1:{server.port}", "Upgrade: websocket",
        "Connection: Upgrade", f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13",
        f"Sec-WebSocket-Protocol: {subprotocol()}", f"Authorization: Bearer {TOKEN}", "", "",
    )  # fmt: skip
    link.sendall("\r\n".join(lines).encode())
    answer = b""
    while not answer.endswith(b"\r\n\r\n"):
        answer += link.recv(1)
    assert answer.startswith(b"HTTP/1.1 101"), answer
    credit = {"type": "credit", "frames": 8}
    for message in (
        {"type": "hello", "name": "deaf"},
        {"type": "open", "sequence": SEQUENCE},
        {"type": "play", "frame": 0},
        *[credit] * 20,
    ):
        link.sendall(Frame(Opcode.BINARY, msgpack.packb(message)).serialize(mask=True))
    return link
