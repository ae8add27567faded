"""The socket and what it refuses: bad messages, too large ones, strangers."""

from __future__ import annotations

import uuid
from typing import Any

import msgpack
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from pointbrush.streaming.messages.values import RUN_BYTES
from tests.serving import Served
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer
from tests.streaming.conftest import FRAMES
from tests.waiting import PATIENCE

BAD = [
    (b"", 400),
    (b"\xc1", 400),
    (b"\x81", 400),
    (msgpack.packb([1, 2]), 400),
    (msgpack.packb({1: 2}), 400),
    (msgpack.packb({"type": "unknown"}), 422),
    (msgpack.packb({"type": "open"}), 422),
    (msgpack.packb({"type": "open", "sequence": "none"}), 404),
    (msgpack.packb({"type": "open", "sequence": "../wall"}), 404),
    (msgpack.packb({"type": "seek", "frame": -1}), 422),
    (msgpack.packb({"type": "seek", "frame": FRAMES}), 422),
    (msgpack.packb({"type": "seek", "frame": 2**63}), 422),
    (msgpack.packb({"type": "seek", "frame": 1.5}), 422),
    (msgpack.packb({"type": "seek", "frame": True}), 422),
    (msgpack.packb({"type": "play", "frame": 0, "speed": float("nan")}), 422),
    (msgpack.packb({"type": "play", "frame": 0, "speed": float("inf")}), 422),
    (msgpack.packb({"type": "credit", "frames": 10**6}), 422),
    (msgpack.packb({"type": "forget", "frames": [0] * 70_000}), 400),
    (msgpack.packb({"type": "pause", "extra": 1}), 422),
    (msgpack.packb({"type": "hello", "name": "x" * 65}), 422),
    (msgpack.packb({"type": "hello", "name": b"bytes"}), 422),
    (msgpack.packb({"type": "hello", "name": b"x" * (RUN_BYTES + 1)}), 400),
    (msgpack.packb({"type": "undo", "id": "not a uuid"}), 422),
    (msgpack.packb({"type": "stroke_end", "id": str(uuid.UUID(int=1))}), 422),
    (msgpack.packb(msgpack.ExtType(5, b"x")), 400),
    (b"\x91" * 5000, 400),
]


@pytest.mark.parametrize(("data", "status"), BAD, ids=lambda v: str(v)[:50])
def test_bad_messages_are_answered_and_the_session_goes_on(
    served: Served, data: bytes, status: int
) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall")
            await client.socket.send(data)
            error = await client.until("error")
            assert error["status"] == status, error
            assert error["detail"]
            await client.hello()

    run(scenario)


def test_messages_before_open(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            for message in (
                {"type": "play", "frame": 0},
                {"type": "seek", "frame": 0},
                {"type": "presence"},
                {"type": "undo", "id": str(uuid.uuid4())},
            ):
                await client.send(**message)
                assert (await client.until("error"))["status"] == 422

    run(scenario)


async def send_and_read(client: Viewer, data: bytes | str) -> None:
    await client.socket.send(data)
    await client.drain(PATIENCE)


def test_too_large_and_text_messages_close_the_socket(served: Served) -> None:
    async def scenario() -> None:
        limit = served.workspace.settings.max_message
        for data, code in ((b"x" * (limit + 1), 1009), ("text", 1003)):
            async with viewer(served.url, served.token) as client:
                with pytest.raises(ConnectionClosed) as closed:
                    await send_and_read(client, data)
                assert closed.value.rcvd is not None
                assert closed.value.rcvd.code == code

    run(scenario)


@pytest.mark.parametrize(
    ("fields", "status"),
    [
        ({"token": ""}, 401),
        ({"token": "wrong"}, 401),
        ({"origin": "http://evil.example"}, 403),
        ({"protocol": "pointbrush.000000000000"}, 403),
    ],
)
def test_refused_handshakes(served: Served, fields: dict[str, Any], status: int) -> None:
    async def scenario() -> None:
        arguments = {"token": served.token} | fields
        with pytest.raises(InvalidStatus) as refused:
            async with viewer(served.url, **arguments):
                pass
        assert refused.value.response.status_code == status
        assert b"status" in refused.value.response.body

    run(scenario)


def test_a_viewers_question_is_refused_by_its_id(served: Served) -> None:
    secret = served.workspace.labels.tokens.add("viewer", "asks only")

    async def scenario() -> None:
        async with viewer(served.url, secret) as client:
            await client.open("wall")
            question = str(uuid.uuid4())
            brush = {"label": 1, "shape": "object", "radius": 0.1}
            sample = {"origin": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}
            await client.send(type="ask", id=question, frame=0, brush=brush, samples=[sample])
            error = await client.until("error", about=question)
            assert error["status"] == 403
            assert "annotator" in error["detail"]

    run(scenario)
