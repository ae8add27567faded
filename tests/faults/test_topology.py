"""The topology of docker-compose.yml on loopback: servers, workers and PostgreSQL come and go."""

from __future__ import annotations

import subprocess
import sys
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from waiting import eventually

from tests.faults.server import ServerProcess, running
from tests.ports import free_port, listening
from tests.postgres import PostgresServer
from tests.serving import add_sequence, settings_in

ROOT = "/sequences/ball"
FRAMES = 6


@contextmanager
def dask(*command: str) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen(
        [sys.executable, "-m", *command, "--no-dashboard"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


class Lab:
    """All parts but the proxy; servers by number."""

    def __init__(self, folder: Path, database: str, stack: ExitStack) -> None:
        self.settings = settings_in(folder)
        self.stack, port = stack, free_port()
        self.scheduler = f"tcp://127.0.0.1:{port}"
        self.options = {"POINTBRUSH_DATABASE": database, "POINTBRUSH_SCHEDULER": self.scheduler}
        add_sequence(self.settings, "ball", frames=FRAMES, points=5_000)
        at = ("--host", "127.0.0.1", "--port", str(port))
        stack.enter_context(dask("distributed.cli.dask_scheduler", *at))
        eventually(lambda: listening(port))

    def worker(self) -> subprocess.Popen[bytes]:
        where = (self.scheduler, "--nthreads", "1", "--no-nanny", "--host", "127.0.0.1")
        return self.stack.enter_context(dask("distributed.cli.dask_worker", *where))

    def server(self) -> ServerProcess:
        return self.stack.enter_context(running(self.settings.workspace, **self.options))


class Person:
    """An annotator, whose strokes go to the other server when theirs has gone, as by the proxy."""

    def __init__(self) -> None:
        self.answered: list[str] = []

    def paint(self, *servers: ServerProcess) -> None:
        x = 0.05 * len(self.answered) - 0.5
        samples = [{"origin": [x, 0.0, 3.0]}]
        asked = {"id": str(uuid.uuid4()), "label": 1, "radius": 0.3, "samples": samples}
        eventually(lambda: any(self._sent(server, asked) for server in servers), every=0.1)
        self.answered.append(str(asked["id"]))

    @staticmethod
    def _sent(server: ServerProcess, asked: dict[str, Any]) -> bool:
        try:
            with server.api() as api:
                return api.post(f"{ROOT}/frames/0/strokes", json=asked).is_success
        except httpx.TransportError:
            return False


def shown(server: ServerProcess) -> bytes:
    with server.api() as api:
        return api.get(f"{ROOT}/frames/0/annotation").raise_for_status().content


def state_of(server: ServerProcess, job: str) -> str:
    with server.api() as api:
        found = api.get(f"/jobs/{job}")
        return str(found.json()["state"]) if found.is_success else ""


@pytest.mark.timeout(900)
def test_a_lab_loses_its_parts_one_by_one_and_no_edit(
    tmp_path: Path,
    postgres_server: PostgresServer,
) -> None:
    ann, ben = Person(), Person()
    with ExitStack() as stack:
        lab = Lab(tmp_path, postgres_server.new_labels(), stack)
        worker = lab.worker()
        here, there = lab.server(), lab.server()
        with here.api() as api:
            api.post(f"{ROOT}/labels", json={"name": "pin"}).raise_for_status()

        # Two annotators at two servers see each other.
        for person, own, other in ((ann, here, there), (ben, there, here)):
            person.paint(own)
            eventually(lambda one=own, two=other: shown(one) == shown(two))

        # A worker and the server of a run are killed; the other server begins the run again.
        with here.api() as api:
            run = {"start": 0, "stop": FRAMES - 1, "method": "icp"}
            job = str(api.post(f"{ROOT}/tracking", json=run).raise_for_status().json()["id"])
        worker.kill()
        here.kill()
        lab.worker()
        ann.paint(here, there)
        eventually(lambda: state_of(there, job) == "done", every=0.2)
        here = lab.server()
        assert state_of(here, job) == "done"

        # PostgreSQL is restarted: strokes are refused, sent again, and there once.
        postgres_server.stop()
        postgres_server.start()
        ann.paint(here)
        ben.paint(there)

        # A rolling restart: each server drains while people go on.
        assert here.stop() == 0
        ann.paint(here, there)
        here = lab.server()
        assert there.stop() == 0
        ben.paint(there, here)

        with here.api() as api:
            edits = [edit["id"] for edit in api.get(f"{ROOT}/edits").raise_for_status().json()]
        assert [edits.count(edit) for edit in ann.answered + ben.answered] == [1] * 7
        assert api_of_run(here, job) in edits


def api_of_run(server: ServerProcess, job: str) -> str:
    with server.api() as api:
        return str(api.get(f"/jobs/{job}").json()["result"]["edit"])
