"""Deleting across servers and without a database: refused in words, or done, and nobody cut off."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from waiting import eventually

from tests.faults.clients import RefusedError, SocketTalk
from tests.faults.server import TOKEN, ServerProcess, two_servers
from tests.postgres import PostgresServer

ROOT = "/sequences/ball"
LONG = 40
"""Frames of a run that is still going on when somebody deletes its recording."""


@pytest.fixture
def servers(
    tmp_path: Path,
    postgres_server: PostgresServer,
) -> Iterator[tuple[ServerProcess, ServerProcess]]:
    url = postgres_server.new_labels()
    with two_servers(tmp_path, url, frames=LONG, points=4_000) as (here, there):
        with here.api() as api:
            api.post(f"{ROOT}/labels", json={"name": "pin"}).raise_for_status()
            stroke = {"label": 1, "radius": 0.4, "samples": [{"origin": [0.2, 0.1, 3.0]}]}
            api.post(f"{ROOT}/frames/0/strokes", json=stroke).raise_for_status()
        yield here, there


def listed(api: httpx.Client, **query: Any) -> list[str]:
    return [entry["id"] for entry in api.get("/sequences", params=query).json()]


def test_deleted_on_one_server_while_another_tracks_and_shows_it(
    servers: tuple[ServerProcess, ServerProcess],
) -> None:
    here, there = servers
    with here.api() as api, there.api() as other:
        asked = {"labels": [1], "start": 0, "stop": LONG - 1, "method": "auto"}
        job = api.post(f"{ROOT}/tracking", json=asked).json()
        refused = other.delete(ROOT)
        assert refused.status_code == 409
        assert "is being tracked" in refused.json()["detail"]
        api.delete(f"/jobs/{job['id']}")
        ended = ("done", "failed", "cancelled")
        eventually(lambda: api.get(f"/jobs/{job['id']}").json()["state"] in ended)
        with SocketTalk(here.url, TOKEN) as viewer:
            eventually(lambda: other.delete(ROOT).status_code == 204)
            with pytest.raises(RefusedError, match="deleted"):
                viewer.until("job")
            assert listed(api) == listed(other) == []
            assert other.post(f"{ROOT}/restore").json()["id"] == "ball"
            viewer.send(type="open", sequence="ball")
            assert viewer.until("sequence")["id"] == "ball"
        assert len(api.get(f"{ROOT}/edits").json()) == len(other.get(f"{ROOT}/edits").json()) > 0


def test_without_the_database_nothing_is_deleted(
    servers: tuple[ServerProcess, ServerProcess],
    postgres_server: PostgresServer,
) -> None:
    here, _ = servers
    with here.api() as api:
        before = api.get(f"{ROOT}/frames/0/annotation").content
        postgres_server.stop()
        try:
            refused = api.delete(ROOT)
        finally:
            postgres_server.start()
        assert refused.status_code == 503
        assert "nothing was changed" in refused.json()["detail"]
        eventually(lambda: api.get("/sequences").status_code == 200)
        assert listed(api) == ["ball"]
        assert listed(api, deleted=True) == []
        assert api.get(f"{ROOT}/frames/0/annotation").content == before
        assert api.delete(ROOT).status_code == 204
        assert listed(api, deleted=True) == ["ball"]
