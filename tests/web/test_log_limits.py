"""What callers without a token can make the log grow by."""

from __future__ import annotations

import logging
import socket
import struct
from collections.abc import Iterator
from pathlib import Path

import pytest

from pointbrush.streaming.schema import subprotocol
from pointbrush.web.log_limits import LINES_A_MINUTE, LineLimit
from tests.faults.server import TOKEN, ServerProcess, running
from tests.serving import settings_in

TRIES = 20
RESET = struct.pack("ii", 1, 0)


@pytest.fixture(params=["text", "json"])
def server(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[ServerProcess]:
    workspace = settings_in(tmp_path).workspace
    with running(workspace, POINTBRUSH_LOG_FORMAT=request.param) as started:
        yield started


def place(server: ServerProcess) -> tuple[str, int]:
    host, _, port = server.url.removeprefix("http://").partition(":")
    return host, int(port)


def drop(server: ServerProcess, *headers: str) -> None:
    """Ask for a socket, and go away without reading the answer."""
    lines = [
        "GET /api/v1/stream HTTP/1.1", f"Host: {server.url.removeprefix('http://')}",
        "Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
        f"Sec-WebSocket-Protocol: {subprotocol()}", *headers, "", "",
    ]  # fmt: skip
    with socket.create_connection(place(server)) as client:
        client.sendall("\r\n".join(lines).encode())
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)


def ask(server: ServerProcess, request: bytes) -> None:
    """Send a request that is none, and wait for its refusal."""
    with socket.create_connection(place(server)) as client:
        client.sendall(request)
        assert client.recv(1000)


def test_a_socket_dropped_during_its_handshake_writes_one_line_at_most(
    server: ServerProcess,
) -> None:
    for headers in ((), ("Authorization: Bearer wrong",), (f"Authorization: Bearer {TOKEN}",)):
        for _ in range(TRIES):
            drop(server, *headers)
    assert server.stop() == 0
    lines = server.stderr.splitlines()
    assert len(lines) <= 3 * TRIES
    assert [line for line in lines if "Traceback" in line or "ERROR" in line] == []


def test_floods_are_folded_and_known_callers_are_logged_each(server: ServerProcess) -> None:
    flood = 4 * LINES_A_MINUTE
    kinds = (
        b"\0 no request\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: h2c\r\n\r\n",
        b"GET /api/v1/me?token=x HTTP/1.1\r\nHost: localhost\r\n\r\n",
        b"GET /" + b"x" * 5_000 + b" HTTP/1.1\r\nHost: localhost\r\n\r\n",
    )
    for _ in range(flood):
        for request in kinds:
            ask(server, request)
    with server.api() as api:
        for _ in range(flood):
            assert api.get("/me").status_code == 200
    assert server.stop() == 0
    lines = server.stderr.splitlines()
    known = [line for line in lines if '"path": "/api/v1/me", "status": 200' in line]
    assert len(known) in (0, flood)
    # The tries may lie in two minutes; there are three places that log about them.
    strangers = [line for line in lines if line not in known]
    assert len(strangers) <= 2 * 3 * LINES_A_MINUTE
    assert max(map(len, strangers)) < 600


def test_what_was_left_out_is_told_with_the_next_line() -> None:
    now = 0.0
    limit = LineLimit(2, clock=lambda: now)

    def passes(message: str = "refused", **extra: object) -> str | None:
        record = logging.LogRecord("x", logging.INFO, "a.py", 7, message, (), None)
        record.__dict__.update(extra)
        return record.getMessage() if limit.filter(record) else None

    assert [passes() for _ in range(4)] == ["refused", "refused", None, None]
    assert passes(known=True) == "refused"
    now = 60.0
    assert passes() == "refused (2 more lines like it were left out)"
    assert passes() == "refused"
