"""The socket and who is at it: presence, roles, tokens, and a sequence that goes."""

from __future__ import annotations

import asyncio
import uuid

import pytest
from websockets.exceptions import ConnectionClosed

from tests.serving import Served
from tests.streaming.acting import run
from tests.streaming.client import viewer


def test_presence_goes_to_the_others_in_the_same_sequence(served: Served) -> None:
    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as anna,
            viewer(served.url, served.token) as ben,
            viewer(served.url, served.token) as other,
        ):
            await anna.hello("Anna")
            await anna.open("wall")
            await ben.open("wall")
            await other.open("other")
            for i in range(200):
                await anna.send(type="presence", frame=3, head=[i, 0, 0, 0, 0, 0, 1])
            seen = await ben.until("presence", name="Anna")
            while seen["head"][0] != 199:
                seen = await ben.until("presence", name="Anna")
            told = [m for m in ben.log if m["type"] == "presence"]
            assert len(told) < 60, "newest wins: not every movement is relayed"
            await anna.socket.close()
            assert (await ben.until("presence", left=True))["name"] == "Anna"
            await other.drain(0.2)
            assert not [m for m in other.log if m["type"] == "presence"]
            assert not [m for m in anna.log if m["type"] == "presence"]

    run(scenario)


def test_a_viewers_token_names_its_author_and_may_not_paint(served: Served) -> None:
    secret = served.workspace.store.tokens.add("viewer", "looks only")

    async def scenario() -> None:
        async with viewer(served.url, secret) as client:
            welcome = await client.hello("Mallory")
            # A token with a name of its own cannot borrow another author's.
            assert (welcome["author"], welcome["role"]) == ("looks only", "viewer")
            await client.open("wall")
            stroke = str(uuid.uuid4())
            await client.send(type="stroke_begin", id=stroke, frame=0, brush={"label": 1})
            error = await client.until("error")
            assert (error["status"], error["about"]) == (403, stroke)

    run(scenario)


def test_a_revoked_tokens_socket_is_closed(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    from pointbrush.web import socket

    monkeypatch.setattr(socket, "RECHECK_SECONDS", 0.1)
    tokens = served.workspace.store.tokens
    secret = tokens.add("annotator", "leaves soon")

    async def scenario() -> None:
        async with viewer(served.url, secret) as client:
            await client.open("wall")
            tokens.revoke(next(token.id for token in tokens.list() if token.name == "leaves soon"))
            with pytest.raises(ConnectionClosed) as closed:
                await client.drain(10)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 4401

    run(scenario)


def test_own_origin_is_welcome(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, origin=served.url) as client:
            await client.hello()

    run(scenario)


def test_deleting_a_sequence_tells_its_viewers(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("other")
            await asyncio.to_thread(served.workspace.delete_sequence, "other")
            assert (await client.until("error"))["status"] == 404
            await client.open("wall")

    run(scenario)
