"""A scripted viewer: the page's side of the socket in Python, for tests and benchmarks."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from ssl import SSLContext
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray
from websockets.asyncio.client import ClientConnection, connect

from pointbrush.streaming.schema import subprotocol
from pointbrush.streaming.shared.board import CELL
from tests.serving import Served
from tests.waiting import PATIENCE

Message = dict[str, Any]
POINTS = ("frame", "depth")
"""Messages that bring points."""


@dataclass
class HeldFrame:
    """What a viewer has of one frame."""

    total: int
    points: int = 0
    final: bool = False
    chunks: list[dict[str, Any]] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)
    values: NDArray[np.uint16] | None = None
    revision: int = 0


def cells_of(timeline: Message) -> NDArray[Any]:
    """The cells of a ``timeline`` message, a row each."""
    assert CELL.names is not None
    columns = [np.frombuffer(timeline[name], CELL[name]) for name in CELL.names]
    return np.rec.fromarrays(columns, CELL)


@dataclass
class Viewer:
    """Sends and receives; keeps frames and their label values as the page does."""

    socket: ClientConnection
    keep_data: bool = False
    auto_credit: bool = True
    log: list[Message] = field(default_factory=list)
    frames: dict[int, HeldFrame] = field(default_factory=dict)
    arrivals: list[tuple[float, int, int]] = field(default_factory=list)
    """Time, frame and number of points of each frame message."""
    nbytes: int = 0
    gaps: int = 0
    on_message: Callable[[Message], None] | None = None

    async def send(self, **message: Any) -> None:
        await self.socket.send(msgpack.packb(message))

    async def receive(self, timeout: float = PATIENCE) -> Message:
        """The next message, applied."""
        data = await asyncio.wait_for(self.socket.recv(), timeout)
        assert isinstance(data, bytes)
        message: Message = msgpack.unpackb(data)
        await self._apply(message, len(data))
        return message

    async def _apply(self, message: Message, nbytes: int) -> None:
        if message["type"] in POINTS:
            self._frame(message)
            self.nbytes += nbytes
            if self.auto_credit:
                await self.send(type="credit", frames=1, nbytes=nbytes)
        elif message["type"] == "annotation":
            self._annotation(message)
        if message["type"] not in POINTS or self.keep_data:
            self.log.append(message)
        if self.on_message is not None:
            self.on_message(message)

    def _frame(self, message: Message) -> None:
        held = self.frames.setdefault(message["frame"], HeldFrame(message["total"]))
        held.total = message["total"]
        added = sum(chunk["count"] for chunk in message["chunks"])
        held.points += added
        held.final |= message["final"]
        held.chunks += message["chunks"]
        if self.keep_data:
            held.data.append(message["data"])
        self.arrivals.append((time.monotonic(), message["frame"], held.points))

    def _annotation(self, message: Message) -> None:
        lengths = np.frombuffer(message["lengths"], "<u4")
        values = np.frombuffer(message["values"], "<u2")
        held = self.frames.setdefault(message["frame"], HeldFrame(0))
        if message["base"] is None:
            run = np.repeat(values, lengths)
            assert len(run) == message["count"]
            held.values = self._grown(held, message["first"] + message["count"])
            held.values[message["first"] : message["first"] + message["count"]] = run
        elif not message["provisional"]:
            if message["base"] > held.revision:
                self.gaps += 1
            size = int(lengths[-1]) + 1 if len(lengths) else 0
            held.values = self._grown(held, size)
            held.values[lengths] = values
        held.revision = max(held.revision, message["revision"])

    @staticmethod
    def _grown(held: HeldFrame, size: int) -> NDArray[np.uint16]:
        old = np.zeros(0, np.uint16) if held.values is None else held.values
        grown = np.zeros(max(size, len(old)), np.uint16)
        grown[: len(old)] = old
        return grown

    async def until(self, kind: str, timeout: float = PATIENCE, **fields: Any) -> Message:
        """Receive until a message of this type with these fields comes."""
        end = time.monotonic() + timeout
        while True:
            message = await self.receive(max(0.001, end - time.monotonic()))
            if message["type"] == kind and all(message[k] == v for k, v in fields.items()):
                return message

    async def drain(self, seconds: float) -> None:
        """Receive whatever comes for a while."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            try:
                await self.receive(left)
            except TimeoutError:
                return

    async def hello(self, name: str = "", **fields: Any) -> Message:
        await self.send(type="hello", name=name, **fields)
        return await self.until("welcome")

    async def open(self, sequence: str, **fields: Any) -> Message:
        await self.send(type="open", sequence=sequence, **fields)
        return await self.until("sequence")


@asynccontextmanager
async def viewer(
    url: str,
    token: str,
    *,
    protocol: str | None = None,
    origin: str | None = None,
    headers: Mapping[str, str] | None = None,
    ssl: SSLContext | None = None,
    **fields: Any,
) -> AsyncIterator[Viewer]:
    """A connected viewer; ``url`` is the server's http or https URL."""
    address = url.replace("http", "ws", 1) + "/api/v1/stream"
    bearer = {"Authorization": f"Bearer {token}"} if token else {}
    async with connect(
        address,
        ssl=ssl,
        additional_headers={**bearer, **(headers or {})},
        subprotocols=[protocol or subprotocol()],  # type: ignore[list-item]
        origin=origin,  # type: ignore[arg-type]
        max_size=None,
        compression=None,
        close_timeout=1,
    ) as socket:
        yield Viewer(socket, **fields)


@asynccontextmanager
async def two_viewers(served: Served) -> AsyncIterator[tuple[Viewer, Viewer]]:
    """Two viewers of one server."""
    async with (
        viewer(served.url, served.token) as anna,
        viewer(served.url, served.token) as ben,
    ):
        yield anna, ben
