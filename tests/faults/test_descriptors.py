"""The process may open no more files, or write no more into them: 503 in words, then it goes on."""

from __future__ import annotations

import os
import socket
import sys
import time
import uuid
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import httpx
import pytest
from waiting import PATIENCE, eventually

from tests.faults.server import TOKEN, ServerProcess, running
from tests.faults.test_private import ended, scan, upload
from tests.serving import add_sequence, settings_in
from tests.torture.machine import descriptors, limited

resource = pytest.importorskip("resource")
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="sets limits of other processes")
FILES = 256


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerProcess]:
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=2, points=5_000)
    with running(settings.workspace) as started:
        with started.api() as api:
            api.post("/sequences/wall/labels", json={"name": "pin"}).raise_for_status()
        yield started


def ticks(server: ServerProcess) -> int:
    """Processor time that the server has used, clock ticks."""
    fields = Path(f"/proc/{server.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return int(fields[11]) + int(fields[12])


def connect(server: ServerProcess) -> socket.socket:
    host, _, port = server.url.removeprefix("http://").partition(":")
    return socket.create_connection((host, int(port)), timeout=PATIENCE)


def stroke(api: httpx.Client) -> httpx.Response:
    body = {"id": str(uuid.uuid4()), "label": 1, "radius": 0.2, "samples": [{"origin": [0, 0, 3]}]}
    return api.post("/sequences/wall/frames/0/strokes", json=body)


def require_words(response: httpx.Response, *words: str) -> None:
    assert response.status_code == 503, response.text
    assert response.headers["content-type"] == "application/problem+json"
    problem: dict[str, Any] = response.json()
    assert problem["status"] == 503
    assert any(word in problem["detail"] for word in words), problem


def test_more_connections_than_files_are_refused_in_words(server: ServerProcess) -> None:
    with limited(server.process.pid, resource.RLIMIT_NOFILE, FILES), server.api() as early:
        assert stroke(early).status_code == 200
        with ExitStack() as held:
            for _ in range(FILES // 2 + 8):
                held.enter_context(connect(server))
            eventually(lambda: descriptors(server.process.pid) > FILES // 2)
            assert descriptors(server.process.pid) < FILES
            with httpx.Client(base_url=server.url) as late:
                require_words(late.get("/healthz"), "connections")
            # Whoever has a connection works on.
            for _ in range(5):
                assert stroke(early).status_code == 200
        with server.api() as api:
            eventually(lambda: answers(api))
            assert stroke(api).status_code == 200
    assert "Traceback" not in server.stderr


def answers(api: httpx.Client) -> bool:
    return api.get("/sequences").status_code == 200


def rests(server: ServerProcess) -> bool:
    """Return whether the server uses less than half a core for a second."""
    used = ticks(server)
    time.sleep(1)
    return ticks(server) - used < os.sysconf("SC_CLK_TCK") / 2


def test_a_flood_beyond_every_file_ends_nothing(server: ServerProcess) -> None:
    with server.api() as early:
        assert stroke(early).status_code == 200
        # A thread that still opens files to import them may take the loop's spare descriptor.
        eventually(lambda: rests(server))
        process = server.process.pid
        few = limited(process, resource.RLIMIT_NOFILE, descriptors(process) + 2)
        with few, ExitStack() as held:
            for _ in range(60):
                held.enter_context(connect(server))
            for path in ("/sequences/wall/frames/0/points", "/sequences/wall/frames/1/annotation"):
                answer = early.get(path)
                assert answer.status_code in (200, 503), answer.text
            data = {"files": ("scan.npy", scan(200_000))}
            require_words(early.post("/sequences", files=data), "files open", "database")
            eventually(lambda: rests(server))  # an accept loop that spins never does
        for _ in range(3):
            with server.api() as api:
                eventually(lambda: answers(api))
                assert stroke(api).status_code == 200
                assert ended(api, upload(api, "scan.npy", scan()))["state"] == "done"


def test_files_may_grow_no_more(server: ServerProcess) -> None:
    with server.api() as api:
        with limited(server.process.pid, resource.RLIMIT_FSIZE, 4096):
            require_words(stroke(api), "database")
            refused = api.post("/sequences", files={"files": ("scan.npy", scan(200_000))})
            require_words(refused, "room")
            assert answers(api)
        assert stroke(api).status_code == 200
        assert ended(api, upload(api, "scan.npy", scan()))["state"] == "done"
    assert TOKEN not in server.stderr
    assert "Traceback" not in server.stderr
