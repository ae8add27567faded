"""Authors edit over HTTPS, while strangers break off their handshakes."""

from __future__ import annotations

import socket
import time
from contextlib import suppress

import pytest

from tests.faults.server import ServerProcess, running
from tests.torture.authors import Authors, quiet
from tests.torture.framework import Arena, scenario

STRANGERS = 20
GREETINGS = (
    b"",
    b"\x16\x03\x01\x02\x00\x01",
    b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
    b"\xff" * 300,
)
"""First bytes of strangers: none, half a handshake, plain HTTP, noise."""


@scenario("six authors edit over HTTPS while other clients abort handshakes", 1)
def encrypted(arena: Arena) -> None:
    """The authors trust the server's own authority, and nobody else."""
    workspace = arena.folder / "workspace"
    authors = Authors(workspace, arena.seed)
    server = arena.stack.enter_context(running(workspace, POINTBRUSH_TLS="true"))
    patch = arena.stack.enter_context(pytest.MonkeyPatch.context())
    patch.setenv("SSL_CERT_FILE", str(workspace / "tls" / "authority.pem"))
    for _ in arena.rounds():
        with authors.editing(lambda: [server.url]):
            for _ in range(STRANGERS):
                _break_off(server, arena.rng.choice(GREETINGS))
                time.sleep(arena.rng.uniform(0.0, 0.2))
        authors.settle(server, arena.tally)
    quiet(server, arena.tally)


def _break_off(server: ServerProcess, greeting: bytes) -> None:
    with suppress(OSError), socket.create_connection(("127.0.0.1", server.port), 5) as link:
        link.sendall(greeting)
