"""Round trips to PostgreSQL: over a network each of them is what a stroke waits for."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace

POINTS = 500
LATENCY_SECONDS = 0.02
MOST_OF_A_STROKE, MOST_OF_A_READ = 4, 2


def readable(links: list[socket.socket], timeout: float | None = None) -> list[socket.socket]:
    """Wait until some of the links can be read; a process may have more files than select takes."""
    poll = select.poll()
    for link in links:
        poll.register(link, select.POLLIN)
    ready = {number for number, _ in poll.poll(timeout)}
    return [link for link in links if link.fileno() in ready]


class CountingProxy:
    """Passes bytes on; ``trips`` counts how often a client spoke after it had been answered."""

    def __init__(self, host: str, port: int) -> None:
        self.trips = 0
        self._target = (host, port)
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = self._server.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        self._server.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._server.accept()
                threading.Thread(target=self._pass_on, args=(client,), daemon=True).start()

    def _pass_on(self, client: socket.socket) -> None:
        answered = True
        with client, socket.create_connection(self._target) as server:
            while True:
                for source in readable([client, server]):
                    try:
                        data = source.recv(1 << 16)
                    except OSError:
                        return
                    if not data:
                        return
                    if source is client and answered:
                        self.trips += 1
                    if source is server:
                        # As over a network: what is sent without waiting is sent meanwhile.
                        time.sleep(LATENCY_SECONDS)
                        if readable([client], 0):
                            server.sendall(client.recv(1 << 16))
                    answered = source is server
                    (server if source is client else client).sendall(data)


@pytest.fixture
def proxy(labels_url: str) -> Iterator[CountingProxy]:
    parts = urlsplit(labels_url)
    made = CountingProxy(str(parts.hostname), int(parts.port or 5432))
    yield made
    made.close()


def test_a_stroke_and_a_read_wait_for_few_round_trips(
    tmp_path: Path,
    labels_url: str,
    proxy: CountingProxy,
) -> None:
    place = tmp_path / "ws"
    xyz = np.random.default_rng(0).uniform(-1, 1, (POINTS, 3)).astype(np.float32)
    import_frames([PointFrame(xyz)], place / "sequences" / "s", RecordingInfo("s", "s", 1.0))
    parts = urlsplit(labels_url)
    url = labels_url.replace(f":{parts.port}/", f":{proxy.port}/")
    with closing(Workspace(Settings(workspace=place, database=url))) as workspace:
        store = workspace.labels
        store.create_label("s", "ann", name="one")

        def stroke(turn: int) -> None:
            workspace.strokes.apply(
                "s",
                0,
                {
                    "id": str(uuid.UUID(int=turn, version=4)),
                    "label": 1,
                    "radius": 0.3,
                    "samples": [{"origin": xyz[turn].tolist()}],
                },
                "ann",
            )

        def trips(work: Callable[[], object]) -> int:
            before = proxy.trips
            work()
            return proxy.trips - before

        # The first ones connect, read blocks, and have their statements prepared.
        for turn in range(8):
            stroke(turn)
            store.values("s", 0)
        assert (
            max(trips(lambda turn=turn: stroke(turn)) for turn in range(8, 16)) <= MOST_OF_A_STROKE
        )
        for read in (
            lambda: store.values("s", 0),
            lambda: store.palette("s"),
            lambda: store.counts("s"),
            lambda: store.revision("s"),
        ):
            assert trips(read) <= MOST_OF_A_READ
