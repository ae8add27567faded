"""Files of recordings are cut short while they are read, and made whole again."""

from __future__ import annotations

import itertools
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path

import httpx
import msgpack
import pytest
from websockets.exceptions import WebSocketException

from pointbrush.sequences import importer
from tests.faults.clients import SEQUENCE, SocketTalk
from tests.faults.server import TOKEN, ServerProcess, running
from tests.serving import add_sequence, settings_in
from tests.torture.authors import quiet
from tests.torture.framework import Arena, Tally, alongside, scenario
from tests.waiting import eventually

FRAMES, POINTS, OCTREE_POINTS = 4, 60_000, 200_000
OCTREE = "octree"
STROKE = {"label": 1, "radius": 0.3, "samples": [{"origin": [0.0, 0.0, 3.0]}]}
READERS = 4
TITLE = "Damaged recording"


def _paths(sequence: str, frame: int) -> tuple[str, ...]:
    root = f"/sequences/{sequence}"
    at = f"{root}/frames/{frame}"
    return (f"{at}/points", f"{at}/points?format=npz", f"{at}/chunks/0", f"{at}/annotation",
            f"{root}/export?format=ply")  # fmt: skip


class Readers:
    """Threads that read everything of two recordings, and paint."""

    def __init__(self, server: ServerProcess, tally: Tally) -> None:
        self._server, self._tally, self._stop = server, tally, threading.Event()
        self._lock = threading.Lock()

    def reading(self) -> AbstractContextManager[None]:
        """Read until the context ends."""
        return alongside(self._stop, [self._read] * READERS + [self._watch])

    def _read(self) -> None:
        frames = itertools.cycle([(SEQUENCE, i) for i in range(FRAMES)] + [(OCTREE, 0)])
        with self._server.api() as api:
            while not self._stop.is_set():
                sequence, frame = next(frames)
                for path in _paths(sequence, frame):
                    self._ask(lambda path=path: api.get(path))
                path = f"/sequences/{sequence}/frames/{frame}/strokes"
                self._ask(lambda path=path: api.post(path, json=STROKE))

    def _ask(self, call: Callable[[], httpx.Response]) -> None:
        """Count an answer, unless it breaks off where a file was cut; whether all live is seen."""
        with suppress(httpx.TransportError):
            self._count(call())

    def _watch(self) -> None:
        gone = (WebSocketException, TimeoutError, httpx.TransportError)
        with suppress(*gone), SocketTalk(self._server.url, TOKEN, "ann") as talk:
            talk.send(type="play", frame=0)
            while not self._stop.is_set():
                message = msgpack.unpackb(talk.socket.recv(timeout=2))
                if message["type"] == "frame":
                    talk.send(type="credit", frames=1)

    def _count(self, response: httpx.Response) -> None:
        """Count an answer; damage is told in words that name the frame."""
        with self._lock:
            if response.status_code == 500 and response.json()["title"] == TITLE:
                self._tally.damaged += 1
            else:
                self._tally.status(response.status_code, response.text[:500])


@contextmanager
def cut(path: Path, share: float) -> Iterator[None]:
    """A file has only ``share`` of its bytes until the context ends."""
    whole = path.read_bytes()
    os.truncate(path, int(len(whole) * share))
    try:
        yield
    finally:
        with path.open("r+b") as file:
            file.write(whole)
        os.utime(path)  # a state of its own, also within the clock's step


@scenario("files of recordings are truncated while they are read", 1)
def files_cut(arena: Arena) -> None:
    """The server lives, tells what is damaged, and serves it again when it is whole."""
    settings = settings_in(arena.folder)
    add_sequence(settings, SEQUENCE, frames=FRAMES, points=POINTS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(importer, "LARGE_POINTS", POINTS)
        add_sequence(settings, OCTREE, frames=1, points=OCTREE_POINTS)
    server = arena.stack.enter_context(running(settings.workspace))
    with server.api() as api:
        for sequence in (SEQUENCE, OCTREE):
            api.post(f"/sequences/{sequence}/labels", json={"name": "pin"}).raise_for_status()
    frames = settings.workspace / "sequences"
    files = sorted(path for path in frames.glob("*/frames/**/*") if path.is_file())
    readers = Readers(server, arena.tally)
    for _ in arena.rounds():
        with readers.reading():
            for _ in range(10):
                with cut(arena.rng.choice(files), arena.rng.uniform(0.0, 0.9)):
                    time.sleep(arena.rng.uniform(0.0, 0.3))
        assert server.process.poll() is None, f"the server has ended: {server.process.poll()}"
        _whole(server)
        assert arena.tally.answered, "nothing was answered"
    quiet(server, arena.tally)


def _whole(server: ServerProcess) -> None:
    """All is served again."""
    with server.api() as api:
        paths = [path for frame in range(FRAMES) for path in _paths(SEQUENCE, frame)]
        for path in (*paths, *_paths(OCTREE, 0)):
            eventually(lambda path=path: api.get(path).is_success, 30)
