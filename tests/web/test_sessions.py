"""Sessions, accounts, and what a token that was revoked, or guessed at, comes to."""

from __future__ import annotations

import asyncio
import os
import re
import signal
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.streaming.schema import subprotocol
from tests.forked import ForkedCommand, first_line
from tests.serving import TOKEN, Served, add_sequence, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import viewer
from tests.waiting import PATIENCE


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=2, points=2_000)
    with serving(settings) as running:
        running.workspace.labels.create_label("wall", "somebody", name="pin")
        yield running


@contextmanager
def signed_in(served: Served, token: str = TOKEN) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=f"{served.url}/api/v1", headers={"Origin": served.url}) as client:
        assert client.post("/session", json={"token": token}).status_code == 200
        yield client


def session_of(client: httpx.Client) -> tuple[str, str]:
    """Name and value of the cookie that lets in."""
    [found] = [item for item in client.cookies.items() if item[0].startswith("pointbrush_session")]
    return found


def paint(client: httpx.Client, x: float) -> None:
    stroke = {"label": 1, "radius": 0.4, "samples": [{"origin": [x, 0, 3]}]}
    answer = client.post("/sequences/wall/frames/0/strokes", json=stroke)
    assert answer.status_code == 200, answer.text


def test_the_cookie_is_a_session_that_signing_out_ends(served: Served) -> None:
    with signed_in(served) as client:
        name, session = session_of(client)
        assert TOKEN not in session
        assert client.delete("/session").status_code == 204
        client.cookies.set(name, session)
        assert client.get("/session").status_code == 401


def test_revoking_a_token_ends_its_sessions(served: Served) -> None:
    tokens = served.workspace.labels.tokens
    with signed_in(served, tokens.add("annotator", "ada")) as client:
        assert client.get("/me").json()["author"] == "ada"
        tokens.revoke(tokens.list()[0].id)
        assert client.get("/me").status_code == 401


def test_sessions_of_the_servers_own_token_end_when_it_changes(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    with serving(settings) as running, signed_in(running) as client:
        _, session = session_of(client)
    with serving(settings_in(tmp_path, token="another token of the owner")) as running:
        name = f"pointbrush_session_{running.url.rpartition(':')[2]}"
        with httpx.Client(base_url=f"{running.url}/api/v1", cookies={name: session}) as client:
            assert client.get("/me").status_code == 401


def test_undo_under_the_shared_token_goes_by_session(served: Served) -> None:
    with signed_in(served) as one, signed_in(served) as other:
        paint(one, -1)
        paint(other, 1)
        assert one.post("/sequences/wall/undo").status_code == 200
        assert one.post("/sequences/wall/undo").status_code == 409
        undone = [edit["undone"] for edit in one.get("/sequences/wall/edits").json()[:3]]
        assert undone == [False, False, True]
        assert {e["author"] for e in one.get("/sequences/wall/edits").json()[:3]} == {"owner"}


def test_a_name_chosen_under_the_shared_token_undoes_nobodys_stroke(served: Served) -> None:
    ada = served.workspace.labels.tokens.add("annotator", "ada")
    headers = {"Authorization": f"Bearer {ada}"}
    with httpx.Client(base_url=f"{served.url}/api/v1", headers=headers) as client:
        paint(client, -1)

    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.send(type="hello", name="ada")
            welcome = await client.until("welcome", author="ada")
            assert welcome["author"] == "ada"
            await client.open("wall", frame=0)
            await client.send(type="undo", id=str(uuid.uuid4()))
            refused = await client.until("error")
            assert refused["status"] == 409

    run(scenario)


@pytest.mark.parametrize(
    "name", ["owner", " Owner ", "command line", "session:1", "token 1", "a\x07"]
)
def test_names_that_no_token_may_have(served: Served, name: str) -> None:
    with pytest.raises(BadInputError, match="name: expected"):
        served.workspace.labels.tokens.add("annotator", name)


def test_two_valid_tokens_have_two_names(served: Served) -> None:
    tokens = served.workspace.labels.tokens
    tokens.add("annotator", "ada")
    with pytest.raises(ConflictError, match="'ada'"):
        tokens.add("viewer", "ada")
    tokens.revoke(tokens.list()[0].id)
    tokens.add("viewer", "ada")


def test_a_revoked_token_paints_nothing_after_the_next_message(served: Served) -> None:
    tokens = served.workspace.labels.tokens
    secret = tokens.add("annotator", "ada")

    async def scenario() -> None:
        async with viewer(served.url, secret) as client:
            await client.open("wall", frame=0)
            stroke = str(uuid.uuid4())
            brush = {"label": 1, "radius": 0.5}
            await client.send(type="stroke_begin", id=stroke, frame=0, brush=brush)
            sample = {"origin": [0.0, 0.0, 3.0]}
            await client.send(type="stroke_samples", id=stroke, samples=[sample])
            await client.until("stroke_result", id=stroke)
            tokens.revoke(tokens.list()[0].id)
            await client.send(type="stroke_end", id=stroke)
            refused = await client.until("error", about=stroke)
            assert refused["status"] == 401
            await asyncio.wait_for(client.socket.wait_closed(), PATIENCE)
            assert client.socket.close_code == 4401

    run(scenario)
    assert not (served.workspace.annotations.read("wall", 0)[0] == 1).any()


def test_wrong_tokens_are_limited_and_a_right_one_passes(served: Served) -> None:
    def get(token: str) -> int:
        headers = {"Authorization": f"Bearer {token}"}
        return httpx.get(f"{served.url}/api/v1/me", headers=headers).status_code

    answers = [get(f"wrong {i}") for i in range(30)]
    assert answers[0] == 401
    assert answers[-1] == 429
    assert get(TOKEN) == 200

    async def socket(token: str) -> int:
        headers = {"Authorization": f"Bearer {token}"}
        url = served.url.replace("http", "ws") + "/api/v1/stream"
        try:
            async with connect(url, subprotocols=[subprotocol()], additional_headers=headers):  # type: ignore[list-item]
                return 101
        except InvalidStatus as refused:
            return refused.response.status_code

    async def scenario() -> None:
        assert await socket("wrong") == 429
        assert await socket(TOKEN) == 101

    run(scenario)


@pytest.mark.parametrize("given", ["", "a-token-that-the-operator-set"])
def test_a_token_that_the_operator_set_is_not_printed(tmp_path: Path, given: str) -> None:
    environment = os.environ | {"POINTBRUSH_TOKEN": given}
    arguments = ("serve", "--port", "0", "--workspace", str(tmp_path / "w"))
    stdout, stderr = tmp_path / "stdout", tmp_path / "stderr"
    server = ForkedCommand(arguments, environment, stdout, stderr)
    line = first_line(server, stdout)
    server.send_signal(signal.SIGTERM)
    server.wait(PATIENCE)
    rest = stdout.read_text().removeprefix(line) + stderr.read_text()
    if given:
        assert given not in line + rest
        assert re.search(r"ready at http://127\.0\.0\.1:\d+$", line)
    else:
        token = line.partition("?token=")[2].strip()
        assert len(token) > 20
        assert token not in rest
