"""Files of a recording are cut short or changed under a server: that frame fails, in words."""

from __future__ import annotations

import io
import json
import os
import sqlite3
import subprocess
import uuid
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import msgpack
import numpy as np
import pytest

from pointbrush.sequences import importer
from tests.faults.clients import ENDED, SEQUENCE, SocketTalk
from tests.faults.server import TOKEN, ServerProcess, running
from tests.forked import run
from tests.serving import add_sequence, settings_in
from tests.waiting import PATIENCE, eventually

POINTS, FRAMES, BAD = 60_000, 4, 2
"""Points of a frame: several pages of each array, so that a cut one is missing some."""
ENDS = ["palette.json", "classes.json", "export.json", "gaps.json"]
STROKE = {"label": 1, "radius": 0.3, "samples": [{"origin": [0.0, 0.0, 3.0]}]}


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    settings = settings_in(tmp_path)
    add_sequence(settings, SEQUENCE, frames=FRAMES, points=POINTS)
    return settings.workspace


@pytest.fixture
def server(workspace: Path) -> Iterator[ServerProcess]:
    with running(workspace) as started:
        with started.api() as api:
            api.post(f"/sequences/{SEQUENCE}/labels", json={"name": "pin"}).raise_for_status()
        yield started


@pytest.fixture
def octree(tmp_path: Path) -> Iterator[ServerProcess]:
    """A server with one frame that is an octree."""
    settings = settings_in(tmp_path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(importer, "LARGE_POINTS", 50_000)
        add_sequence(settings, SEQUENCE, frames=1, points=200_000)
    with running(settings.workspace) as started:
        with started.api() as api:
            api.post(f"/sequences/{SEQUENCE}/labels", json={"name": "pin"}).raise_for_status()
        yield started


def frame_file(server: ServerProcess, name: str) -> Path:
    return server.workspace / "sequences" / SEQUENCE / "frames" / name


def cut(path: Path, share: float = 0.3) -> None:
    os.truncate(path, int(path.stat().st_size * share))


def flip(path: Path) -> None:
    """Change one byte, as a disk would: time and length stay."""
    found = path.stat()
    with path.open("r+b") as file:
        file.seek(found.st_size // 2)
        byte = file.read(1)[0]
        file.seek(found.st_size // 2)
        file.write(bytes([byte ^ 0x10]))
    os.utime(path, ns=(found.st_atime_ns, found.st_mtime_ns))


def require_told(response: httpx.Response, frame: int = BAD) -> None:
    """A problem that names the frame."""
    assert response.status_code == 500, (response.status_code, response.text[:300])
    assert response.headers["content-type"] == "application/problem+json"
    assert response.json()["title"] == "Damaged recording"
    assert f"frame {frame} is damaged" in response.json()["detail"]
    assert str(Path.home()) not in response.json()["detail"]


def stroke(api: httpx.Client, frame: int) -> httpx.Response:
    body = {**STROKE, "id": str(uuid.uuid4())}
    return api.post(f"/sequences/{SEQUENCE}/frames/{frame}/strokes", json=body)


def chunks(api: httpx.Client, frame: int) -> httpx.Response:
    return api.get(f"/sequences/{SEQUENCE}/frames/{frame}/chunks/0")


def points(api: httpx.Client, frame: int, form: str = "npy") -> httpx.Response:
    return api.get(f"/sequences/{SEQUENCE}/frames/{frame}/points", params={"format": form})


class Watching(SocketTalk):
    """A viewer that keeps what it is sent apart: frames and errors."""

    def __init__(self, url: str) -> None:
        super().__init__(url, TOKEN, "ann")
        self.frames: set[int] = set()
        self.errors: list[dict[str, Any]] = []

    def watch(self, until: Callable[[], bool]) -> None:
        while not until():
            message = msgpack.unpackb(self.socket.recv(timeout=PATIENCE))
            if message["type"] == "frame":
                self.frames.add(message["frame"])
                self.send(type="credit", frames=1)
            elif message["type"] == "error":
                self.errors.append(message)


def test_bytes_for_the_wire_cut_while_served(server: ServerProcess) -> None:
    with server.api() as api:
        assert chunks(api, BAD).status_code == 200  # mapped from here on
        cut(frame_file(server, f"{BAD:06d}.wire"))
        last = len(api.get(f"/sequences/{SEQUENCE}/frames/{BAD}/chunks").json()["chunks"]) - 1
        require_told(api.get(f"/sequences/{SEQUENCE}/frames/{BAD}/chunks/{last}"))
        require_told(chunks(api, BAD))
        assert stroke(api, BAD).json()["changed"] > 0  # its points are whole
        with Watching(server.url) as ann:
            for told in (1, 2):  # it is told once, and again each time the frame is sought
                ann.watch(lambda told=told: len(ann.errors) >= told)  # type: ignore[misc]
                ann.send(type="seek", frame=BAD)
            assert {error["title"] for error in ann.errors} == {"Damaged recording"}
            assert f"frame {BAD} is damaged" in ann.errors[0]["detail"]
            ann.watch(lambda: {0, 1, 3} <= ann.frames)
            assert BAD not in ann.frames
            ann.send(type="play", frame=0, speed=4.0, loop=True)
            edit = {"kind": "stroke", "id": str(uuid.uuid4()), "frame": 0, "stroke": dict(STROKE)}
            assert ann.do(edit)["edit"] == edit["id"]
    assert server.process.poll() is None
    assert "Traceback" not in server.stderr


@pytest.mark.parametrize("seen", [False, True])
def test_points_cut_while_served(server: ServerProcess, seen: bool) -> None:
    """The server lives, other frames go on; strokes go on in what was copied before."""
    with server.api() as api:
        if seen:
            assert stroke(api, BAD).status_code == 200
        cut(frame_file(server, f"{BAD:06d}.points"), 0.6)
        require_told(points(api, BAD))
        require_told(points(api, BAD, "npz"))
        if seen:
            assert stroke(api, BAD).status_code == 200
        else:
            require_told(stroke(api, BAD))
        assert stroke(api, 0).json()["changed"] > 0
        body = {"start": 0, "stop": 3, "labels": [1], "method": "icp"}
        job = api.post(f"/sequences/{SEQUENCE}/tracking", json=body).raise_for_status().json()

        def ended() -> dict[str, Any] | None:
            now: dict[str, Any] = api.get(f"/jobs/{job['id']}").json()
            return now if now["state"] in ENDED else None

        failed = eventually(ended)
        assert failed["state"] == "failed"
        assert f"frame {BAD} is damaged" in failed["error"]
    assert server.process.poll() is None


def test_an_octree_cut_while_served(octree: ServerProcess) -> None:
    with octree.api() as api:
        assert stroke(api, 0).json()["changed"] > 0  # its columns are mapped
        table = api.get(f"/sequences/{SEQUENCE}/frames/0/chunks").json()["chunks"]
        live = SocketTalk(octree.url, TOKEN, "ann")
        edit = str(uuid.uuid4())
        brush = {"label": 1, "radius": 0.3}
        live.send(type="stroke_begin", id=edit, frame=0, brush=brush)
        live.send(type="stroke_samples", id=edit, samples=STROKE["samples"])
        for name in ("coordinates", "source_index"):
            cut(frame_file(octree, f"000000/{name}.npy"))
        cut(frame_file(octree, "000000.wire"))
        live.send(type="stroke_samples", id=edit, samples=STROKE["samples"])
        while True:
            message = msgpack.unpackb(live.socket.recv(timeout=PATIENCE))
            if message["type"] == "error" and message["about"] == edit:
                break
        assert "frame 0 is damaged" in message["detail"]
        require_told(stroke(api, 0), 0)
        require_told(points(api, 0), 0)
        require_told(points(api, 0, "npz"), 0)
        require_told(api.get(f"/sequences/{SEQUENCE}/frames/0/annotation"), 0)
        require_told(api.get(f"/sequences/{SEQUENCE}/frames/0/chunks/{len(table) - 1}"), 0)
        live.socket.close()
        live.api.close()
    assert octree.process.poll() is None


def test_a_changed_bit_is_noticed_when_it_is_served(workspace: Path) -> None:
    frames = workspace / "sequences" / SEQUENCE / "frames"
    flip(frames / "000001.points")
    flip(frames / "000002.wire")
    with running(workspace) as server, server.api() as api:
        require_told(points(api, 1), 1)
        require_told(chunks(api, 2), 2)
        # What is only looked up in is compared in the background.
        eventually(lambda: chunks(api, 1).status_code == 500)
        require_told(chunks(api, 1), 1)
        assert points(api, 2).status_code == 200
        assert chunks(api, 3).status_code == 200
        with Watching(server.url) as ann:
            ann.watch(lambda: len(ann.errors) > 0 and {0, 3} <= ann.frames)
            assert {error["title"] for error in ann.errors} == {"Damaged recording"}
        # Put back as it was, it is served again.
        flip(frames / "000001.points")
        os.utime(frames / "000001.points")
        again = points(api, 1).raise_for_status()
        assert np.load(io.BytesIO(again.content)).shape == (POINTS + 10,)
        assert chunks(api, 1).status_code == 200


def test_a_changed_bit_in_an_octree_is_noticed(octree: ServerProcess) -> None:
    octree.kill()
    flip(frame_file(octree, "000000/rgb.npy"))
    with running(octree.workspace) as server, server.api() as api:
        eventually(lambda: points(api, 0).status_code == 500)
        require_told(points(api, 0), 0)


@pytest.mark.parametrize("form", ["ply", "semantickitti", "boxes"])
def test_an_export_of_a_damaged_frame_is_refused_before_it_begins(
    workspace: Path, tmp_path: Path, form: str
) -> None:
    flip(workspace / "sequences" / SEQUENCE / "frames" / f"{BAD:06d}.points")
    with running(workspace) as server, server.api() as api:
        path = f"/sequences/{SEQUENCE}/export?format={form}"
        require_told(api.get(path))
        whole = api.get(f"{path}&frames=0:{BAD}").raise_for_status()
        assert zipfile.ZipFile(io.BytesIO(whole.content)).testzip() is None
    out = tmp_path / "out"
    where = ("--workspace", str(workspace), "--out", str(out))
    said = run("export", SEQUENCE, "--format", form, *where)
    assert said.returncode == 1
    assert f"frame {BAD} is damaged" in said.stderr
    assert said.stderr.count("\n") <= 2
    assert "Traceback" not in said.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["workspace"]


def test_a_frame_damaged_while_it_is_exported_is_a_named_gap(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(importer, "LARGE_POINTS", 50_000)
        add_sequence(settings, SEQUENCE, frames=FRAMES, points=250_000)
    with running(settings.workspace) as server, server.api() as api:
        path = f"/sequences/{SEQUENCE}/export?format=ply"
        with api.stream("GET", path) as answer:
            assert answer.status_code == 200
            pieces = answer.iter_bytes()
            content = next(pieces)  # the server is ahead by 16 pieces at most
            cut(frame_file(server, f"{FRAMES - 1:06d}/coordinates.npy"))
            content += b"".join(pieces)
        archive = zipfile.ZipFile(io.BytesIO(content))
        assert archive.testzip() is None
        assert archive.namelist() == ["000000.ply", "000001.ply", "000002.ply", *ENDS]
        gaps = json.loads(archive.read("gaps.json"))["gaps"]
        assert len(gaps) == 1
        assert f"frame {FRAMES - 1} is damaged" in gaps[0]
    assert "Traceback" not in server.stderr


def run_check(workspace: Path, *flags: str) -> subprocess.CompletedProcess[str]:
    return run("check", *flags, "--workspace", str(workspace))


def test_check_tells_what_is_wrong_and_repairs_what_it_can(server: ServerProcess) -> None:
    with server.api() as api:
        assert stroke(api, 0).json()["changed"] > 0
    assert server.stop() == 0
    workspace, folder = server.workspace, server.workspace / "sequences" / SEQUENCE
    assert "are sound" in run_check(workspace).stdout

    flip(folder / "frames" / "000001.wire")
    with sqlite3.connect(workspace / "labels.sqlite") as connection:
        connection.execute("UPDATE counts SET points = points + 1")
    connection.close()
    (folder / "checksums.json").rename(folder.parent / "kept")
    told = run_check(workspace)
    assert told.returncode == 1
    assert "counts: frame 0, label 1" in told.stdout
    assert "changed bytes of the frames cannot be noticed" in told.stdout
    (folder.parent / "kept").rename(folder / "checksums.json")
    mended = run_check(workspace, "--repair")
    assert mended.returncode == 1
    assert f"rebuilt: {SEQUENCE}: counts: frame 0, label 1" in mended.stdout
    assert f"cannot be rebuilt: {SEQUENCE}: frames/000001.wire" in mended.stdout

    flip(folder / "frames" / "000001.wire")
    assert "are sound" in run_check(workspace).stdout
    (folder / "checksums.json").unlink()
    mended = run_check(workspace, "--repair")
    assert (mended.returncode, "are sound" in mended.stdout) == (0, True), mended.stdout
    assert "had no checksums" in mended.stdout

    path = workspace / "labels.sqlite"
    content = bytearray(path.read_bytes())
    size = int.from_bytes(content[16:18], "big")
    for start in range(3 * size, len(content), 2 * size):
        content[start : start + size] = bytes(size)
    path.write_bytes(content)
    for flags in ((), ("--repair",)):
        told = run_check(workspace, *flags)
        assert told.returncode == 1
        assert "database: " in told.stdout, (told.stdout, told.stderr)
        assert "Traceback" not in told.stderr
