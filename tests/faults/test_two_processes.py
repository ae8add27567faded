"""Two servers on one PostgreSQL database serve one recording as one."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from waiting import eventually

from tests.faults.clients import SocketTalk
from tests.faults.server import TOKEN, ServerProcess, two_servers
from tests.postgres import PostgresServer

ROOT = "/sequences/ball"


@pytest.fixture
def servers(
    tmp_path: Path,
    postgres_server: PostgresServer,
) -> Iterator[tuple[ServerProcess, ServerProcess]]:
    with two_servers(tmp_path, postgres_server.new_labels(), frames=2, points=5_000) as both:
        yield both


def stroke(x: float) -> dict[str, Any]:
    samples = [{"origin": [x, 0.0, 3.0]}]
    return {"id": str(uuid.uuid4()), "label": 1, "radius": 0.4, "samples": samples}


def shown(api: httpx.Client) -> tuple[bytes, str]:
    response = api.get(f"{ROOT}/frames/0/annotation").raise_for_status()
    return response.content, response.headers["etag"]


def paint(api: httpx.Client, asked: dict[str, Any]) -> httpx.Response:
    return api.post(f"{ROOT}/frames/0/strokes", json=asked)


def delta_of(talk: SocketTalk, edit: str) -> dict[str, Any]:
    """The annotation message that an edit brings."""
    while (message := talk.until("annotation"))["edit"] != edit:
        pass
    return message


def test_edits_cross_and_an_absent_database_is_no_end(
    servers: tuple[ServerProcess, ServerProcess],
    postgres_server: PostgresServer,
) -> None:
    here, there = servers
    with (
        here.api() as api,
        there.api() as other,
        SocketTalk(there.url, TOKEN, "viewer") as viewer,
    ):
        api.post(f"{ROOT}/labels", json={"name": "pin"}).raise_for_status()
        # A frame comes with all edits until then: only who holds it is told of a single one.
        viewer.until("annotation")
        first = stroke(0.0)
        answer = paint(api, first).raise_for_status().json()
        delta = delta_of(viewer, first["id"])
        assert delta["revision"] == answer["revision"] == 2
        assert len(np.frombuffer(delta["lengths"], "<u4")) == answer["changed"] > 0
        assert shown(api) == shown(other)

        # The same stroke to the other server, as after a lost connection: once.
        assert paint(other, first).raise_for_status().json() == answer
        # One author at both: undo takes back what was painted here.
        assert other.post(f"{ROOT}/undo").raise_for_status().json()["changed"] == answer["changed"]
        assert not np.frombuffer(shown(api)[0][-5_000:], np.uint8).any()

        postgres_server.stop()
        try:
            lost = stroke(0.5)
            for client in (api, other):
                refused = paint(client, lost)
                assert refused.status_code == 503, refused.text
                assert refused.headers["content-type"] == "application/problem+json"
                assert client.get(f"{ROOT}/frames/0/annotation").status_code == 503
                assert client.get("/healthz").status_code == 200
        finally:
            postgres_server.start()
        assert eventually(lambda: paint(api, lost).is_success)
        assert delta_of(viewer, lost["id"])["revision"] == 4
        assert paint(other, lost).json()["revision"] == 4
        assert shown(api) == shown(other)
