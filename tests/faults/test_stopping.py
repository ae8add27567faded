"""SIGTERM: what was sent is answered, then the server goes, with exit code 0."""

from __future__ import annotations

import json
import signal
import socket
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from waiting import PATIENCE, eventually

from tests.faults.clients import SocketTalk
from tests.faults.server import TOKEN, ServerProcess, running
from tests.serving import add_sequence, settings_in
from tests.web.test_ending import children

SAMPLES = [{"origin": [0.6 * (-1) ** i, 0.02 * i - 0.4, 3.0]} for i in range(40)]
"""A stroke to and fro."""


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ServerProcess]:
    settings = settings_in(tmp_path)
    add_sequence(settings, "ball", frames=2, points=5_000)
    with running(settings.workspace, POINTBRUSH_NEW_LABELS="1") as started:
        with started.api() as api:
            api.post("/sequences/ball/labels", json={"name": "pin"}).raise_for_status()
        yield started


def stroke(**fields: Any) -> dict[str, Any]:
    return {"id": str(uuid.uuid4()), "label": 1, "radius": 0.3, "samples": SAMPLES, **fields}


def revision_of(workspace: Path, edit: str) -> int | None:
    """Where the next server has the edit."""
    with running(workspace) as server, server.api() as api:
        rows = api.get("/sequences/ball/edits").json()
        return next((row["revision"] for row in rows if row["id"] == edit), None)


def test_a_stroke_over_rest_is_answered(server: ServerProcess) -> None:
    asked = stroke()
    body = json.dumps(asked).encode()
    head = (
        "POST /api/v1/sequences/ball/frames/0/strokes HTTP/1.1\r\nHost: 127.0.0.1\r\n"
        f"Authorization: Bearer {TOKEN}\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\nExpect: 100-continue\r\n\r\n"
    )
    port = int(server.url.rpartition(":")[2])
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as link:
        link.sendall(head.encode())
        assert b"100 Continue" in link.recv(1000)  # from here on the stroke is on its way
        link.sendall(body)
        server.process.send_signal(signal.SIGTERM)
        answer = b""
        while piece := link.recv(65536):
            answer += piece
    assert b"HTTP/1.1 200" in answer, answer
    assert server.process.wait(PATIENCE) == 0
    said = json.loads(answer.partition(b"\r\n\r\n")[2])
    assert said["changed"] > 0
    assert revision_of(server.workspace, asked["id"]) == said["revision"]
    assert server.stderr == ""


def test_a_stroke_over_the_socket_is_answered_and_a_job_does_not_hold_it_up(
    server: ServerProcess,
) -> None:
    asked = stroke()
    with SocketTalk(server.url, TOKEN, "ann") as ann, server.api() as api:
        api.post("/sequences/ball/frames/0/strokes", json=stroke(samples=SAMPLES[:1]))
        job = api.post("/sequences/ball/tracking", json={"start": 0, "stop": 1, "method": "icp"})
        assert job.status_code == 202
        brush = {"label": 1, "radius": 0.3}
        ann.send(type="stroke_begin", id=asked["id"], frame=0, brush=brush)
        ann.send(type="stroke_samples", id=asked["id"], samples=SAMPLES)
        ann.send(type="stroke_end", id=asked["id"])
        ann.send(type="hello", name="ann")
        ann.until("welcome")  # so what came before has been heard
        server.process.send_signal(signal.SIGTERM)
        answer = ann.until("stroke_result", asked["id"])
    assert server.process.wait(PATIENCE) == 0
    assert revision_of(server.workspace, asked["id"]) == answer["revision"]


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="no /proc to find workers in")
def test_a_killed_server_leaves_no_worker_behind(server: ServerProcess) -> None:
    with server.api() as api:
        api.post("/sequences/ball/frames/0/strokes", json=stroke(samples=SAMPLES[:1]))
        api.post("/sequences/ball/tracking", json={"start": 0, "stop": 1, "method": "icp"})
        workers = eventually(lambda: children(server.process.pid))
    server.kill()
    eventually(lambda: not any(alive(worker) for worker in workers))


def alive(process: int) -> bool:
    """Whether a process runs; one that nobody has waited for yet does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
