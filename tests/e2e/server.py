"""The command ``pointbrush serve`` in a process of its own, which tests may kill."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Mapping
from contextlib import closing
from io import BytesIO
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.selectors import BUILT_IN, make_selector
from pointbrush.settings import Settings
from pointbrush.web import server as web_server
from pointbrush.work.objects.preparing import StateFiles, prepare_file
from pointbrush.workspace import Workspace
from tests.forked import FORKSERVER, run_here
from tests.ports import kept_port
from tests.waiting import PATIENCE

TOKEN = "end-to-end-token-of-the-owner"


def serve(workspace: Path, port: int, log: Path, added: Mapping[str, str]) -> None:
    """Run the command with ``log`` for a screen and variables added to the environment."""
    # Few of these tests track: a worker that is made ready costs as much as all else of a server.
    web_server.expect_tracking = lambda _: None
    arguments = ["serve", "--workspace", str(workspace), "--port", str(port)]
    run_here(arguments, os.environ | added, workspace.parent, log, log)


def complete(workspace: Path) -> None:
    """Add the database, and what the object tool prepares of frames: it looks at every stroke.

    To make these takes longer than all else that a server does for a test.
    """
    making = FORKSERVER.Process(target=_complete, args=(workspace,))
    making.start()
    making.join()
    assert making.exitcode == 0


def _complete(workspace: Path) -> None:
    with closing(Workspace(Settings(workspace=workspace))) as opened:
        for manifest in opened.library.manifests():
            recording, version = opened.recording(manifest.id), make_selector(BUILT_IN).version
            for frame in range(len(recording)):
                files = StateFiles(workspace / "objects", 0)
                target = files.path(recording.identity, BUILT_IN, version, frame)
                assert prepare_file(recording.files, frame, BUILT_IN, target)


class LiveServer:
    """``pointbrush serve``; started, killed and started again.

    All servers of a process have one port, so that browsers keep the page's files in their caches.
    """

    def __init__(self, workspace: Path, **environment: str) -> None:
        self.workspace = workspace
        self.environment = environment
        self.port = kept_port()
        self.token = TOKEN
        self.log = workspace.parent / f"{workspace.name}.log"
        self._process: BaseProcess | None = None
        self._client: httpx.Client | None = None

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def page_url(self) -> str:
        return f"{self.url}/?token={self.token}"

    def start(self) -> None:
        added = {"POINTBRUSH_TOKEN": self.token, **self.environment}
        how = (self.workspace, self.port, self.log, added)
        self._process = FORKSERVER.Process(target=serve, args=how)
        self._process.start()
        # One for all requests: its making reads the system's certificates.
        self._client = httpx.Client(base_url=self.url, timeout=PATIENCE)
        deadline = time.monotonic() + PATIENCE
        while not self._answers():
            assert self._process.is_alive(), self.log.read_text()
            if time.monotonic() > deadline:
                self.kill()
                raise AssertionError("the server did not start")
            time.sleep(0.05)

    def _answers(self) -> bool:
        assert self._client is not None
        try:
            return self._client.get("/healthz", timeout=1).status_code == 200
        except httpx.TransportError:
            return False

    def kill(self) -> None:
        """As a power cut would: nothing is tidied up."""
        # Job workers too: they are children of their own session.
        self._end(os.killpg, signal.SIGKILL)

    def stop(self) -> None:
        self._end(os.kill, signal.SIGTERM)

    def _end(self, send: Callable[[int, int], None], number: signal.Signals) -> None:
        if self._process is None:
            return
        assert self._process.pid is not None
        assert self._client is not None
        self._client.close()
        send(self._process.pid, number)
        self._process.join(PATIENCE)
        assert self._process.exitcode is not None, "the server did not end"
        self._process = None

    # ── REST ─────────────────────────────────────────────────────────────────────────────

    def request(
        self, method: str, path: str, extra: dict[str, str] | None = None, **options: Any
    ) -> httpx.Response:
        assert self._client is not None, "the server does not run"
        headers = {"Authorization": f"Bearer {self.token}", **(extra or {})}
        response = self._client.request(method, f"/api/v1/{path}", headers=headers, **options)
        response.raise_for_status()
        return response

    def annotation(self, sequence: str, frame: int, layer: str = "label") -> NDArray[Any]:
        data = self.request(
            "GET", f"sequences/{sequence}/frames/{frame}/annotation", params={"layer": layer}
        ).content
        return load_npy(data)

    def points(self, sequence: str, frame: int) -> NDArray[Any]:
        """Coordinates (N, 3) in the source's order."""
        data = self.request("GET", f"sequences/{sequence}/frames/{frame}/points").content
        xyz: NDArray[Any] = load_npy(data)["xyz"]
        return xyz

    def put_annotation(self, sequence: str, frame: int, labels: NDArray[Any]) -> None:
        """Replace a frame's labels (N,), the source's order."""
        stream = BytesIO()
        np.save(stream, labels)
        path = f"sequences/{sequence}/frames/{frame}/annotation"
        headers = {"Content-Type": "application/x-npy"}
        self.request("PUT", path, content=stream.getvalue(), extra=headers)

    def create_label(self, sequence: str, name: str, color: str) -> int:
        body = {"name": name, "color": color}
        label: int = self.request("POST", f"sequences/{sequence}/labels", json=body).json()["id"]
        return label


def load_npy(data: bytes) -> NDArray[Any]:
    array: NDArray[Any] = np.load(BytesIO(data), allow_pickle=False)
    return array
