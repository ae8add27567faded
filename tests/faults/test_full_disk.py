"""The disk is full: edits and imports are refused, nothing is lost, and it goes on with room."""

from __future__ import annotations

import io
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from waiting import eventually

from tests.faults.clients import ENDED, RefusedError, SocketTalk
from tests.faults.server import TOKEN, ServerProcess, running
from tests.faults.torture import check
from tests.serving import add_sequence, settings_in, surface
from tests.torture.machine import Ballast, mounted

SIZE = 12 * 2**20
POINTS = 20_000


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 12 MB."""
    with mounted(tmp_path / "disk", SIZE) as folder:
        yield folder


@pytest.fixture
def server(disk: Path, tmp_path: Path) -> Iterator[ServerProcess]:
    settings = settings_in(disk)
    add_sequence(settings, "ball", frames=1, points=POINTS)
    with running(settings.workspace, POINTBRUSH_IMPORT_ROOTS=str(tmp_path)) as started:
        with started.api() as api:
            api.post("/sequences/ball/labels", json={"name": "pin"}).raise_for_status()
        yield started


def stroke(rng: np.random.Generator) -> dict[str, Any]:
    samples = [{"origin": [*rng.uniform(-2, 2, 2), 3.0]} for _ in range(4)]
    return {"id": str(uuid.uuid4()), "label": 1, "radius": 0.5, "samples": samples}


def annotation(api: httpx.Client) -> tuple[bytes, str]:
    response = api.get("/sequences/ball/frames/0/annotation").raise_for_status()
    return response.content, response.headers["etag"]


def require_refusal(response: httpx.Response) -> None:
    assert response.status_code == 503, response.text
    assert response.headers["content-type"] == "application/problem+json"
    assert response.json()["status"] == 503
    assert "full" in response.json()["detail"] or "room" in response.json()["detail"]


def test_edits_are_refused_and_what_was_there_stays(disk: Path, server: ServerProcess) -> None:
    rng, ballast, path = np.random.default_rng(0), Ballast(disk), "/sequences/ball/frames/0/strokes"
    with server.api() as api:
        for _ in range(5):
            api.post(path, json=stroke(rng)).raise_for_status()
        ballast.fill()
        answered = 5
        for _ in range(400):  # the log of the database has some room left of its own
            asked = stroke(rng)
            response = api.post(path, json=asked)
            if response.status_code != 200:
                break
            answered += 1
        require_refusal(response)
        before = annotation(api)
        assert api.get("/sequences/ball").json()["revision"] == answered + 1
        for _ in range(3):
            ballast.fill()
            require_refusal(api.post(path, json=stroke(rng)))
            require_refusal(api.post("/sequences/ball/labels", json={"name": "bottle" * 20}))
            require_refusal(api.post("/sequences/ball/undo"))
        with SocketTalk(server.url, TOKEN, "ann") as ann:
            brush = {"label": 1, "radius": 0.5}
            ann.send(type="stroke_begin", id=asked["id"], frame=0, brush=brush)
            ann.send(type="stroke_samples", id=asked["id"], samples=asked["samples"])
            ann.send(type="stroke_end", id=asked["id"])
            with pytest.raises((RefusedError, AssertionError), match="full"):
                ann.until("stroke_result", asked["id"])
        assert annotation(api) == before
        ballast.drop()
        again = api.post(path, json=asked).raise_for_status().json()
        assert again["revision"] == answered + 2
        painted = annotation(api)[0]
        wiped = api.post(path, json={**stroke(rng), "tool": "erase", "radius": 10.0})
        assert wiped.raise_for_status().json()["changed"] > 0
        assert annotation(api)[0] != painted
        api.post("/sequences/ball/undo").raise_for_status()
        assert annotation(api)[0] == painted
    server.kill()
    check(server.workspace)


def test_an_import_fails_clearly_and_leaves_nothing(
    disk: Path, server: ServerProcess, tmp_path: Path
) -> None:
    xyz = surface(2_000_000, 0).xyz
    source = tmp_path / "scan.npy"
    np.save(source, xyz)
    upload = io.BytesIO()
    np.save(upload, xyz[:60_000])
    recordings, uploads = server.workspace / "sequences", server.workspace / "uploads"
    names = sorted(recordings.iterdir())
    ballast = Ballast(disk)
    with server.api() as api:

        def ended(job: dict[str, Any]) -> dict[str, Any] | None:
            now: dict[str, Any] = api.get(f"/jobs/{job['id']}").json()
            return now if now["state"] in ENDED else None

        job = api.post("/sequences", json={"path": str(source)}).raise_for_status().json()
        failed = eventually(lambda: ended(job))
        assert failed["state"] == "failed"
        assert failed["error"].startswith("expected room on disk for scan"), failed
        assert sorted(recordings.iterdir()) == names

        ballast.fill()
        files = {"files": ("small.npy", upload.getvalue())}
        require_refusal(api.post("/sequences", files=files))
        assert not uploads.exists() or not list(uploads.iterdir())
        require_refusal(api.patch("/sequences/ball", json={"name": "another name" * 10}))
        assert api.get("/sequences/ball").json()["name"] == "ball"

        ballast.drop()
        job = api.post("/sequences", files=files).raise_for_status().json()
        assert eventually(lambda: ended(job))["state"] == "done"
    assert "Traceback" not in server.stderr
