"""Clients that do not read, bodies that trickle, a database that does not answer: others go on."""

from __future__ import annotations

import socket
import time
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import httpx
import psycopg
import pytest
from waiting import PATIENCE, eventually

from pointbrush.teamwork.store import WorkspaceStore
from tests.faults.server import TOKEN, ServerProcess, running
from tests.postgres import PostgresServer
from tests.serving import add_sequence, settings_in

UNREAD = 60
MOST, PER_PERSON = 3, 2


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerProcess]:
    """A server with 20 MB to export, which gives up readers that pause for 2 s."""
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=8, points=150_000)
    limits = {
        "POINTBRUSH_EXPORTS": str(MOST),
        "POINTBRUSH_EXPORTS_PER_PERSON": str(PER_PERSON),
        "POINTBRUSH_STALL_SECONDS": "2",
        "POINTBRUSH_BODY_SECONDS": "3",
    }
    with running(settings.workspace, **limits) as started:
        yield started


def viewer_token(server: ServerProcess, name: str) -> str:
    store = WorkspaceStore(f"sqlite:///{server.workspace / 'labels.sqlite'}")
    try:
        return store.tokens.add("viewer", name)
    finally:
        store.close()


def ask(server: ServerProcess, token: str, path: str) -> socket.socket:
    """A request whose answer is not read."""
    host, _, port = server.url.removeprefix("http://").partition(":")
    link = socket.socket()
    link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    link.settimeout(PATIENCE)
    link.connect((host, int(port)))
    request = f"GET {path} HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\n"
    request += "Connection: close\r\n\r\n"
    link.sendall(request.encode())
    return link


def status(link: socket.socket) -> int:
    """The status line alone."""
    line = b""
    while not line.endswith(b"\r\n"):
        line += link.recv(1)
    return int(line.split()[1])


def require_stroke(api: httpx.Client) -> None:
    stroke = {"id": str(uuid.uuid4()), "label": 1, "radius": 0.2}
    body = stroke | {"samples": [{"origin": [0, 0, 3]}]}
    api.post("/sequences/wall/frames/0/strokes", json=body).raise_for_status()


def test_exports_that_nobody_reads_slow_no_stroke(server: ServerProcess) -> None:
    path = "/api/v1/sequences/wall/export?format=npz"
    ann, bob = viewer_token(server, "ann"), viewer_token(server, "bob")
    with server.api() as api, ExitStack() as open_links:
        api.post("/sequences/wall/labels", json={"name": "pin"}).raise_for_status()
        links = [open_links.enter_context(ask(server, ann, path)) for _ in range(UNREAD)]
        require_stroke(api)
        found = sorted(status(link) for link in links)
        assert found == [200] * PER_PERSON + [429] * (UNREAD - PER_PERSON)
        with server.api(ann) as viewer:
            refused = viewer.get("/sequences/wall/export?format=npz")
            assert refused.status_code == 429
            assert "exports of one person at once" in refused.json()["detail"]
        others = [open_links.enter_context(ask(server, bob, path)) for _ in range(PER_PERSON)]
        assert sorted(status(link) for link in others) == [200, 503]
        require_stroke(api)
        # Nobody reads: they are given up, and there is room again.
        with server.api(ann) as viewer:
            eventually(lambda: viewer.get("/sequences/wall/export?format=npz").is_success)
            whole = len(viewer.get("/sequences/wall/export?format=npz").content)
        assert any(0 < len(rest(link)) < whole for link in links)
    assert "Traceback" not in server.stderr


def rest(link: socket.socket) -> bytes:
    """All that still comes."""
    found = bytearray()
    with suppress(ConnectionError):
        while piece := link.recv(1 << 16):
            found += piece
    return bytes(found)


def test_a_body_that_trickles_is_given_up(server: ServerProcess) -> None:
    host, _, port = server.url.removeprefix("http://").partition(":")
    head = (
        f"POST /api/v1/sequences/wall/labels HTTP/1.1\r\nHost: {host}\r\n"
        f"Authorization: Bearer {TOKEN}\r\nContent-Type: application/json\r\n"
        "Content-Length: 1000\r\n\r\n"
    )
    with socket.create_connection((host, int(port)), timeout=PATIENCE) as link:
        link.sendall(head.encode())
        answer, end = b"", time.monotonic() + PATIENCE
        while b"}" not in answer and time.monotonic() < end:
            if not answer:
                link.sendall(b" ")
            link.settimeout(0.2)
            with suppress(TimeoutError):
                answer += link.recv(4096)
    assert answer.startswith(b"HTTP/1.1 408"), answer
    assert b"expected it whole within 3 seconds" in answer


def test_health_needs_no_database_and_readiness_tells_of_it(
    tmp_path: Path,
    labels_url: str,
) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=1, points=2_000)
    limits = {"POINTBRUSH_DATABASE": labels_url, "POINTBRUSH_STATEMENT_SECONDS": "8"}
    with running(settings.workspace, **limits) as server, httpx.Client(timeout=PATIENCE) as client:
        ready = client.get(f"{server.url}/readyz")
        assert (ready.status_code, ready.json()["status"]) == (200, "ready"), ready.text
        path = "/api/v1/sequences"
        with psycopg.connect(labels_url) as holder, ExitStack() as open_links:
            holder.execute("LOCK TABLE tokens, sequences IN ACCESS EXCLUSIVE MODE")
            # More than there are worker threads; each waits for the table.
            links = [open_links.enter_context(ask(server, "wrong", path)) for _ in range(60)]
            for _ in range(5):
                assert client.get(f"{server.url}/healthz").status_code == 200
            assert status(links[0]) == 503  # the statement's time is over
            holder.rollback()
        with server.api() as api:
            eventually(lambda: api.get("/sequences").status_code == 200)


def test_readiness_tells_that_the_database_is_away(
    tmp_path: Path,
    postgres_server: PostgresServer,
    labels_url: str,
) -> None:
    limits = {"POINTBRUSH_DATABASE": labels_url}
    with (
        running(tmp_path / "workspace", **limits) as server,
        httpx.Client(timeout=PATIENCE) as client,
    ):
        try:
            postgres_server.stop()
            # Answers are kept for a second.
            eventually(lambda: client.get(f"{server.url}/readyz").status_code == 503)
            ready = client.get(f"{server.url}/readyz")
            parts = ready.json()["parts"]
            assert parts["disk"] == parts["scheduler"] == "ok"
            assert "cannot be reached" in parts["database"]
            assert "127.0.0.1" not in ready.text
            assert client.get(f"{server.url}/healthz").status_code == 200
        finally:
            postgres_server.start()
        eventually(lambda: client.get(f"{server.url}/readyz").status_code == 200)
