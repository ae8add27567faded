"""A real server on a free port, and small recordings to serve: for tests and benchmarks."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.web.app import create_app
from pointbrush.web.server import Server, config, listen
from pointbrush.workspace import Workspace
from tests.waiting import PATIENCE, eventually

TOKEN = "test-token-of-the-owner"


@dataclass
class Served:
    """A running server."""

    url: str
    token: str
    workspace: Workspace

    @property
    def headers(self) -> dict[str, str]:
        return {"Authorization": f"Bearer {self.token}"}


def surface(count: int, seed: int, *, offset: float = 0.0) -> PointFrame:
    """A noisy wall with colours, seen by a sensor at the origin: what a depth camera sees."""
    random = np.random.default_rng(seed)
    uv = random.uniform(-1, 1, (count, 2))
    depth = 3 + 0.3 * np.sin(3 * uv[:, 0] + seed * 0.1) + random.normal(0, 0.002, count)
    xyz = np.column_stack([uv[:, 0] * depth, uv[:, 1] * depth, depth]) + offset
    # Of one hue, as light is: three colours at random would be noise, which takes long to encode.
    rgb = (random.integers(0, 240, (count, 1)) + [0, 8, 15]).astype(np.uint8)
    return PointFrame(xyz=xyz.astype(np.float32), rgb=rgb)


def add_sequence(
    settings: Settings, name: str, *, frames: int = 6, points: int = 20_000, fps: float = 30.0
) -> None:
    """Import a recording of ``surface`` frames directly into a workspace folder."""
    import_frames(
        (surface(points + 10 * i, i) for i in range(frames)),
        settings.workspace / "sequences" / name,
        RecordingInfo(name, name, fps),
    )


@cache
def new_labels() -> bytes:
    """The file of a label database without recordings: all migrations take long."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "labels.sqlite"
        WorkspaceStore(f"sqlite:///{path}").close()
        return path.read_bytes()


def settings_in(folder: Path, **options: object) -> Settings:
    """Settings of a test's own workspace, whose label database is up to date and empty."""
    base = Settings(workspace=folder / "workspace", port=0, token=TOKEN, workers=1)
    return with_labels(replace(base, **options))  # type: ignore[arg-type]


def with_labels(settings: Settings) -> Settings:
    """Put an up-to-date label database without recordings into a workspace that has none."""
    labels = settings.workspace / "labels.sqlite"
    if not settings.database and not labels.exists():
        labels.parent.mkdir(parents=True, exist_ok=True)
        labels.write_bytes(new_labels())
    return settings


@contextmanager
def serving(settings: Settings) -> Iterator[Served]:
    """Run uvicorn in a thread until the context ends."""
    workspace = Workspace(settings)
    app = create_app(workspace, settings)
    listener = listen("127.0.0.1", 0)
    server = Server(config(app, settings, None))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    try:
        eventually(lambda: server.started or not thread.is_alive())
        assert server.started, "the server stopped at its start"
        yield Served(f"http://127.0.0.1:{listener.getsockname()[1]}", app.state.token, workspace)
    finally:
        server.should_exit = True
        thread.join(PATIENCE)
        listener.close()
        workspace.close()
        assert not thread.is_alive(), "the server did not stop"
