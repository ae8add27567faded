"""Hostile and broken clients: the others do not notice, and nothing dies or grows."""

from __future__ import annotations

import asyncio
import gc
import resource
import socket
import threading
import time
import tracemalloc
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, suppress

import httpx
import msgpack
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from pointbrush.web.idle_timeout import IdleTimeoutProtocol
from tests.serving import Served, add_sequence, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer
from tests.waiting import comes_true, eventually

UUID = str(uuid.UUID(int=7))
VALID = [
    {"type": "hello", "name": "x"},
    {"type": "open", "sequence": "wall", "frame": 1},
    {"type": "open", "sequence": "wall", "frame": 1, "revision": 0},
    {"type": "play", "frame": 0, "speed": 3.0, "loop": False},
    {"type": "pause", "frame": 2},
    {"type": "seek", "frame": 3},
    {"type": "credit", "frames": 2, "nbytes": 100, "frame_ms": 9.0, "target_ms": 11.0},
    {"type": "forget", "frames": [0, 1, 2]},
    {"type": "want", "frame": 0, "chunks": [0, 1, 5]},
    {"type": "stroke_begin", "id": UUID, "frame": 0, "brush": {"label": 1, "radius": 0.1}},
    {"type": "stroke_samples", "id": UUID, "samples": [{"origin": [0, 0, 3], "t": 1.0}]},
    {"type": "stroke_end", "id": UUID},
    {"type": "undo", "id": UUID},
    {"type": "redo", "id": UUID},
    {"type": "track", "id": UUID, "start": 0, "stop": 0},
    {"type": "presence", "frame": 1, "head": [0, 0, 0, 0, 0, 0, 1]},
]
EVIL = [
    float("nan"), float("inf"), -1, 2**31, 2**63, -(2**63), 1e308, "", "x" * 5000, b"\0" * 100, [],
    {}, None, True, [[]] * 1000, [float("nan")] * 3, {"type": "open"}, "../../etc/passwd", "\ud83d",
]  # fmt: skip


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(8192, hard), hard))
    settings = settings_in(tmp_path_factory.mktemp("hostile"))
    add_sequence(settings, "wall", frames=4, points=2_000)
    with serving(settings) as running:
        running.workspace.labels.create_label("wall", "somebody", name="pin")
        yield running
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def mutated(random: np.random.Generator) -> bytes:
    """A valid message with something wrong in it, or plain noise."""
    if random.random() < 0.2:
        return random.bytes(int(random.integers(0, 200)))
    message = dict(VALID[random.integers(len(VALID))])
    for _ in range(random.integers(0, 3)):
        key = list(message)[random.integers(len(message))]
        message[key] = EVIL[random.integers(len(EVIL))]
    data = bytearray(msgpack.packb(message, unicode_errors="surrogatepass"))
    for _ in range(random.integers(0, 3) if random.random() < 0.5 else 0):
        data[random.integers(len(data))] = random.integers(256)
    return bytes(data[: random.integers(1, len(data) + 1)] if random.random() < 0.2 else data)


async def require_service(served: Served) -> None:
    """Open the recording and paint as a newcomer: a picture and the stroke's answer come."""
    async with viewer(served.url, served.token) as client:
        await client.hello()
        await client.open("wall", frame=0)
        await client.until("frame", frame=0, final=True)
        stroke = str(uuid.uuid4())
        brush = {"label": 1, "radius": 0.2}
        await client.send(type="stroke_begin", id=stroke, frame=0, brush=brush)
        sample = {"origin": [0, 0, 3]}
        await client.send(type="stroke_samples", id=stroke, samples=[sample])
        await client.send(type="stroke_end", id=stroke)
        await client.until("stroke_result", id=stroke, final=True)


async def fuzz(served: Served, seed: int, count: int) -> None:
    """Send ``count`` bad messages, reading along; the session is still there afterwards."""
    random = np.random.default_rng(seed)
    async with viewer(served.url, served.token) as client:
        for _ in range(count):
            await client.socket.send(mutated(random))
            if random.random() < 0.3:
                await client.drain(0.001)
        client.log.clear()
        await client.send(type="hello", name="well")
        await client.until("welcome", author="well")


def test_fuzzed_messages_are_survived(served: Served) -> None:
    async def scenario() -> None:
        await asyncio.gather(*(fuzz(served, seed, 250) for seed in range(6)))
        await require_service(served)

    run(scenario)


def test_fuzzing_does_not_leak(served: Served) -> None:
    async def scenario() -> None:
        await fuzz(served, 100, 100)
        tracemalloc.start()
        try:
            sizes = []
            for seed in range(4):
                await fuzz(served, seed, 150)
                gc.collect()
                sizes.append(tracemalloc.get_traced_memory()[0])
        finally:
            tracemalloc.stop()
        assert sizes[-1] - sizes[0] < 8e6, sizes

    run(scenario)


def address(served: Served) -> tuple[str, int]:
    host, port = served.url.removeprefix("http://").split(":")
    return host, int(port)


def test_requests_that_never_end_keep_nobody_out(served: Served) -> None:
    with ExitStack() as stack:
        for i in range(100):
            raw = stack.enter_context(socket.create_connection(address(served)))
            raw.sendall((b"GET / HTTP/1.1\r\nHost: loc", b"PUT /api/v1/sequences/wall/fr")[i % 2])
        upload = stack.enter_context(socket.create_connection(address(served)))
        upload.sendall(
            b"PUT /api/v1/sequences/wall/frames/0/annotation HTTP/1.1\r\nHost: localhost\r\n"
            b"Content-Length: 4000\r\nAuthorization: Bearer " + served.token.encode() + b"\r\n\r\n"
        )
        assert httpx.get(f"{served.url}/healthz").status_code == 200
        run(lambda: require_service(served))


def trickle(raw: socket.socket) -> None:
    """Send bytes one at a time until the server hangs up."""
    while True:
        raw.sendall(b"G")
        time.sleep(0.05)


def test_headers_that_never_end_are_not_waited_for(
    served: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(IdleTimeoutProtocol, "seconds", 0.3)
    with ExitStack() as stack:
        viewer_socket = stack.enter_context(handshake(served))
        upload = stack.enter_context(socket.create_connection(address(served)))
        upload.sendall(
            b"PUT /api/v1/sequences/wall/frames/0/annotation HTTP/1.1\r\nHost: localhost\r\n"
            b"Content-Length: 3\r\nAuthorization: Bearer " + served.token.encode() + b"\r\n\r\n"
        )
        drip = stack.enter_context(socket.create_connection(address(served)))
        with pytest.raises(OSError, match=r"Broken pipe|reset"):
            trickle(drip)
        # Who is in the middle of a request, or of a socket's life, is not hurried.
        upload.sendall(b"abc")
        assert upload.recv(64).startswith(b"HTTP/1.1 4")
        viewer_socket.setblocking(False)
        with pytest.raises(BlockingIOError):
            viewer_socket.recv(1)


def handshake(served: Served) -> socket.socket:
    """An open WebSocket that nobody reads or writes."""
    from pointbrush.streaming.schema import subprotocol

    raw = socket.create_connection(address(served))
    raw.sendall(
        b"GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
        b"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        + f"Sec-WebSocket-Protocol: {subprotocol()}\r\n"
        f"Authorization: Bearer {served.token}\r\n\r\n".encode()
    )
    assert raw.recv(4096).startswith(b"HTTP/1.1 101")
    return raw


def test_five_hundred_idle_sockets(served: Served) -> None:
    with ExitStack() as stack:
        for _ in range(500):
            stack.enter_context(handshake(served))
        run(lambda: require_service(served))


async def flood(client: Viewer) -> None:
    """Send strokes without end, and read nothing."""
    with suppress(ConnectionClosed):
        while True:
            stroke = str(uuid.uuid4())
            brush = {"label": 1, "radius": 0.1}
            await client.send(type="stroke_begin", id=stroke, frame=1, brush=brush)
            samples = [{"origin": [0, 0, 3]}] * 50
            await client.send(type="stroke_samples", id=stroke, samples=samples)
            await client.send(type="stroke_end", id=stroke)


def test_a_flood_of_strokes_hinders_nobody_else(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=1)
            before = len(served.workspace.labels.edits("wall"))
            flooding = asyncio.create_task(flood(client))
            await comes_true(lambda: len(served.workspace.labels.edits("wall")) > before)
            for _ in range(3):
                await require_service(served)
            flooding.cancel()
            await asyncio.gather(flooding, return_exceptions=True)

    run(scenario)


def test_a_flood_of_small_messages_hinders_nobody_else(served: Served) -> None:
    frame = b"\x82\x81\0\0\0\0\xc1"
    credit = msgpack.packb({"type": "credit", "frames": 1})
    began = threading.Event()
    frame += b"\x82" + bytes([128 | len(credit)]) + b"\0\0\0\0" + credit

    def send(raw: socket.socket) -> None:
        with suppress(OSError):  # not read any more, as its answers are not
            for _ in range(20):
                raw.sendall(frame * 1000)
                began.set()

    async def scenario() -> None:
        with handshake(served) as raw:
            flooding = asyncio.create_task(asyncio.to_thread(send, raw))
            await comes_true(began.is_set)
            for _ in range(3):
                await require_service(served)
            raw.shutdown(socket.SHUT_RDWR)
            await flooding

    run(scenario)


def test_too_many_requests(tmp_path_factory: pytest.TempPathFactory) -> None:
    settings = settings_in(tmp_path_factory.mktemp("limited"), requests_per_second=5)
    with serving(settings) as served, httpx.Client(headers=served.headers) as client:
        answers = [client.get(f"{served.url}/api/v1/me") for _ in range(120)]
        refused = [answer for answer in answers if answer.status_code == 429]
        assert len(refused) > 10
        assert refused[0].headers["retry-after"]
        assert refused[0].headers["content-type"] == "application/problem+json"
        eventually(lambda: client.get(f"{served.url}/api/v1/me").status_code == 200, every=0.5)
