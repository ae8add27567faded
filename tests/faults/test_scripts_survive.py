"""Scripts go on while the server is killed and restarted, and make nothing twice."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from pointbrush.client import AsyncClient, Client
from pointbrush.errors import UnavailableError
from pointbrush.teamwork.store import WorkspaceStore
from tests.faults.clients import SEQUENCE
from tests.faults.server import TOKEN, ServerProcess
from tests.faults.torture import make_workspace
from tests.serving import add_sequence, settings_in
from tests.waiting import eventually

FAR = 120.0
"""Seconds that a busy machine may need to start a server."""


class Restarted:
    """A server that is killed, and begins again at the same address once somebody missed it."""

    def __init__(self, workspace: Path) -> None:
        self.server = ServerProcess(workspace)
        self.missed = threading.Event()
        self._once = threading.Lock()
        self._killed = False

    def kill_once(self) -> None:
        """Kill the server, at the first call only."""
        with self._once:
            if not self._killed:
                self._killed = True
                self.server.kill()

    def begin_again(self) -> None:
        """Start the server anew after a call that found nobody."""
        assert self.missed.wait(FAR), "nobody called while the server was away"
        workspace, port = self.server.workspace, self.server.port
        self.server = ServerProcess(workspace, port=port)


@pytest.fixture
def restarted(tmp_path: Path) -> Iterator[Restarted]:
    workspace = tmp_path / "workspace"
    make_workspace(workspace)
    found = Restarted(workspace)
    yield found
    found.server.kill()


class Killing(httpx.HTTPTransport):
    """A network that kills the server after it has answered a POST, and may lose the answer."""

    def __init__(self, restarted: Restarted, path: str, *, lost: bool = False) -> None:
        super().__init__()
        self._restarted, self._path, self._lost = restarted, path, lost
        self.calls: list[str] = []

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        return self.after(request, lambda: super(Killing, self).handle_request(request))

    def after(self, request: httpx.Request, call: Callable[[], httpx.Response]) -> httpx.Response:
        self.calls.append(f"{request.method} {request.url.path}")
        try:
            answer = call()
        except httpx.TransportError:
            self._restarted.missed.set()
            raise
        if request.method == "POST" and request.url.path.endswith(self._path):
            answer.read()
            first = self.calls.count(self.calls[-1]) == 1
            self._restarted.kill_once()
            if self._lost and first:
                raise httpx.ReadError("lost on the way")
        return answer


def in_thread(work: Callable[[], Any]) -> Callable[[], Any]:
    """Begin ``work``; the answer of the function that is returned is its."""
    found: list[Any] = []

    def run() -> None:
        try:
            found.append(work())
        except BaseException as error:
            found.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()

    def result() -> Any:
        thread.join(FAR)
        assert found, "the script has not ended"
        if isinstance(found[0], BaseException):
            raise found[0]
        return found[0]

    return result


def painted(client: Client) -> int:
    """Make a label with a ball of points in the first frame; returns its id."""
    recording = client[SEQUENCE]
    label = recording.create_label("ball")
    recording.frames[0].stroke(label=label.id, radius=0.15, samples=[[0, 0, 1]])
    return label.id


@pytest.mark.parametrize("lost", [False, True])
def test_tracking_is_waited_for(restarted: Restarted, lost: bool) -> None:
    with Client(restarted.server.url, TOKEN) as client:
        label = painted(client)
    network = Killing(restarted, "/tracking", lost=lost)
    with Client(restarted.server.url, TOKEN, transport=network) as client:
        recording = client[SEQUENCE]
        result = in_thread(lambda: recording.track([label], 0, 3, method="icp", progress=False))
        restarted.begin_again()
        run = result()
        assert (run.frames, run.changed > 0) == (4, True)
        edits = recording.edits()
        assert [edit.id for edit in edits if edit.kind == "tracking"] == [run.edit]


def test_tracking_is_awaited(restarted: Restarted) -> None:
    with Client(restarted.server.url, TOKEN) as client:
        label = painted(client)

    async def script() -> Any:
        async with AsyncClient(restarted.server.url, TOKEN) as client:
            recording = await client[SEQUENCE]
            job = await recording.start_tracking([label], 0, 3, method="icp")
            restarted.kill_once()
            restarted.missed.set()
            return await client.wait(job)

    result = in_thread(lambda: asyncio.run(script()))
    restarted.begin_again()
    assert result()["frames"] == 4


def test_files_are_imported_once(restarted: Restarted, tmp_path: Path) -> None:
    files = [tmp_path / f"{i}.npy" for i in range(3)]
    for i, file in enumerate(files):
        np.save(file, np.full((50, 3), i, np.float32))
    network = Killing(restarted, "/sequences", lost=True)
    with Client(restarted.server.url, TOKEN, transport=network) as client:
        result = in_thread(lambda: client.import_files([str(file) for file in files], name="drift"))
        restarted.begin_again()
        recording = result()
        assert (recording.frames[2].points()["xyz"] == 2).all()
        assert [each.name for each in client.sequences()] == [SEQUENCE, "drift"]
        assert network.calls.count("POST /api/v1/sequences") == 1
        uploads = list((tmp_path / "workspace" / "uploads").glob("*"))
        assert not uploads, "files of an import that has ended"


def test_a_job_of_an_id_is_begun_once(restarted: Restarted, tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.ones((50, 3), np.float32))
    job = "5ac3b6a5-9ce5-4d0e-8b9d-26ab7c4a2f6d"
    with restarted.server.api() as api, (tmp_path / "a.npy").open("rb") as file:
        for _ in range(2):
            sent = {"files": ("a.npy", file)}
            answer = api.post("/sequences", files=sent, data={"id": job.upper()})
            assert (answer.status_code, answer.json()["id"]) == (202, job)
            file.seek(0)
        wrong = api.post("/sequences", files={"files": ("a.npy", file)}, data={"id": "one"})
        assert (wrong.status_code, wrong.json()["detail"].split(":")[0]) == (422, "id")
        eventually(lambda: api.get(f"/jobs/{job}").json()["state"] == "done", FAR)
        assert len(api.get("/jobs").json()) == 1
    store = WorkspaceStore(f"sqlite:///{tmp_path / 'workspace' / 'labels.sqlite'}")
    token = store.tokens.add("annotator", "eve", None)
    store.close()
    with restarted.server.api(token) as other:
        stolen = other.post(
            f"/sequences/{SEQUENCE}/tracking", json={"id": job, "start": 0, "stop": 1}
        )
        assert stolen.status_code == 409


def test_patience_has_an_end(restarted: Restarted) -> None:
    with Client(restarted.server.url, TOKEN) as client:
        label = painted(client)
        job = client[SEQUENCE].start_tracking([label], 0, 3, method="icp")
        restarted.server.kill()
        with pytest.raises(UnavailableError, match="expected a server that answers"):
            client.wait(job, patience=0.5)


def test_a_command_waits_for_its_server(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=60, points=20_000)
    restarted = Restarted(settings.workspace)
    try:
        with Client(restarted.server.url, TOKEN) as client:
            wall = client["wall"]
            label = wall.create_label("brick")
            places = wall.frames[0].points()["xyz"][:1]
            wall.frames[0].stroke(label=label.id, radius=0.5, samples=places)
            command = [
                *(sys.executable, "-m", "pointbrush.cli", "track", "wall", "--labels", "brick"),
                *("--from", "0", "--to", "59", "--method", "icp"),
                *("--server", f"{restarted.server.url}/?token={TOKEN}"),
            ]
            running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            eventually(lambda: client.jobs() and client.jobs()[0].state == "running", FAR)
        restarted.kill_once()
        # The command has said that it goes on without an answer.
        assert running.stderr is not None
        while (said := running.stderr.readline()) and b"is repeated" not in said:
            pass
        assert said, "the command has not missed its server"
        restarted.missed.set()
        restarted.begin_again()
        out, _ = running.communicate(timeout=FAR)
        assert (running.returncode, out.startswith(b"tracked 60 frames")) == (0, True)
    finally:
        restarted.server.kill()
