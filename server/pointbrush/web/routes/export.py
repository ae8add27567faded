"""Exports, streamed while they are written.

Their number is limited; each is written in a separate thread as fast as the client reads.
"""

from __future__ import annotations

import asyncio
import threading
from collections import Counter
from collections.abc import AsyncIterator, Callable
from concurrent.futures import CancelledError
from dataclasses import dataclass
from typing import Annotated, BinaryIO, cast

from fastapi import Query, Request, Response
from fastapi.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

from pointbrush.errors import TooManyRequestsError, UnavailableError
from pointbrush.formats import EXPORTS
from pointbrush.values.exports import ExportFormat
from pointbrush.values.kinds import LONGEST_NAME
from pointbrush.web.context import SequenceId, SnapshotQuery, Ws, one_of
from pointbrush.web.security.auth import Caller, Gate, Principal, resource
from pointbrush.web.security.roles import needs, needs_for_file

PIECES = 16
PIECE = 256 << 10
LOOK_SECONDS = 1.0
"""Interval in which a waiting writer checks whether the client still reads."""
router = resource("export")
FrameRange = Annotated[
    str | None, Query(pattern=r"^[0-9]{0,9}(:[0-9]{0,9})?$", description="I:J, J not included")
]

Validation = Annotated[
    str | None,
    Query(
        max_length=4096,
        description="frames for validation, of formats that split: I:J, ids of recordings with "
        "commas, or none; without it one recording in five, never all",
    ),
]


@dataclass
class Place:
    """One export's place; it is free after its writer and its response have both ended."""

    person: str
    holders: int = 2


class Exports:
    """Places for exports; all calls are from the event loop's thread."""

    def __init__(self, most: int, per_person: int) -> None:
        """``most``: exports at once in all; ``per_person``: exports at once of one person."""
        self._most, self._per_person = most, per_person
        self._taken: Counter[str] = Counter()

    def take(self, person: str) -> Place:
        """Return a place; raises TooManyRequestsError or UnavailableError when there is none."""
        if self._taken[person] >= self._per_person:
            raise TooManyRequestsError(
                f"export: expected at most {self._per_person} exports of one person at once; "
                "finish or stop a running export first"
            )
        if self._taken.total() >= self._most:
            raise UnavailableError(
                f"export: expected at most {self._most} exports on this server at once; "
                "try again when an export has ended"
            )
        self._taken[person] += 1
        return Place(person)

    def leave(self, place: Place) -> None:
        """Note that the writer or the response of ``place`` has ended."""
        place.holders -= 1
        if place.holders == 0:
            self._taken[place.person] -= 1
            if not self._taken[place.person]:
                del self._taken[place.person]


class Pipe:
    """A write-only file for one thread; the event loop reads its pieces."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._pieces: asyncio.Queue[bytes | BaseException | None] = asyncio.Queue(PIECES)
        self._gathered = bytearray()
        self._closed = threading.Event()

    def write(self, data: bytes) -> int:
        """Write ``data``; raise BrokenPipeError after the reader has closed the pipe."""
        self._gathered += data
        if len(self._gathered) >= PIECE:
            self._flush_piece()
        return len(data)

    def flush(self) -> None:
        """Do nothing: pieces are sent when they are large enough."""

    def finish(self, error: BaseException | None) -> None:
        """End the pipe; the reader raises ``error``, if any."""
        try:
            if error is None:
                self._flush_piece()
            self._put(error)
        except BrokenPipeError:
            return

    def _flush_piece(self) -> None:
        piece, self._gathered = bytes(self._gathered), bytearray()
        if piece:
            self._put(piece)

    def _put(self, item: bytes | BaseException | None) -> None:
        if self._closed.is_set() or self._loop.is_closed():
            raise BrokenPipeError("the client has gone")
        waiting = asyncio.run_coroutine_threadsafe(self._pieces.put(item), self._loop)
        while True:
            try:
                waiting.result(LOOK_SECONDS)
                return
            except (TimeoutError, CancelledError):
                if self._closed.is_set() or self._loop.is_closed():
                    waiting.cancel()
                    raise BrokenPipeError("the client has gone") from None

    async def next(self) -> bytes:
        """Return the next piece, empty after the last; raise the writer's error."""
        item = await self._pieces.get()
        if isinstance(item, BaseException):
            raise item
        return item or b""

    def close(self) -> None:
        """Stop reading; the writer ends at its next piece."""
        self._closed.set()
        while not self._pieces.empty():
            self._pieces.get_nowait()


class ExportResponse(StreamingResponse):
    """A response of a pipe's pieces; ``ended`` is called at its end, also after an error."""

    def __init__(
        self, first: bytes, pipe: Pipe, ended: Callable[[], None], headers: dict[str, str]
    ) -> None:
        super().__init__(_body(first, pipe), media_type="application/zip", headers=headers)
        self._ended = ended

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the pieces."""
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._ended()


async def _body(first: bytes, pipe: Pipe) -> AsyncIterator[bytes]:
    piece = first
    while piece:
        yield piece
        piece = await pipe.next()


async def respond(
    exports: Exports,
    person: str,
    write: Callable[[BinaryIO], None],
    headers: dict[str, str],
) -> ExportResponse:
    """Run ``write(file)`` in a thread and return the response of its bytes.

    The first piece is awaited, so that an error before it is still answered as a problem.
    """
    loop = asyncio.get_running_loop()
    pipe, place = Pipe(loop), exports.take(person)

    def run() -> None:
        try:
            write(cast(BinaryIO, pipe))
        except BaseException as error:
            pipe.finish(error)
        else:
            pipe.finish(None)
        finally:
            if not loop.is_closed():
                loop.call_soon_threadsafe(exports.leave, place)

    def ended() -> None:
        pipe.close()
        exports.leave(place)

    try:
        threading.Thread(target=run, name="pointbrush-export", daemon=True).start()
        first = await pipe.next()
    except BaseException:
        ended()
        raise
    return ExportResponse(first, pipe, ended, headers)


@router.get("/exports", **needs("viewer"))
def list_exports() -> list[ExportFormat]:
    """List the export formats in the order of the page."""
    return [ExportFormat.of(each, format=each.name) for each in EXPORTS.values()]


@router.get("/sequences/{seq}/export", **needs_for_file("viewer", "The export", "application/zip"))
async def export_sequence(
    seq: SequenceId,
    workspace: Ws,
    request: Request,
    who: Caller,
    format: Annotated[str, Query(pattern=one_of(EXPORTS), description="from `GET /exports`")],
    frames: FrameRange = None,
    val: Validation = None,
    above: Annotated[
        float, Query(ge=0, le=1, description="least confidence of predicted labels")
    ] = 0.0,
    snapshot: SnapshotQuery = None,
    sensor: Annotated[
        str | None, Query(max_length=LONGEST_NAME, description="name of one of several sensors")
    ] = None,
) -> Response:
    """Return frames with their labels in source order, as a zip.

    ``sensor``: only the points of this sensor, in its own coordinates.
    """
    return await respond(
        request.app.state.exports,
        person_of(request, who),
        lambda file: workspace.export(seq, format, file, frames, val, above, snapshot, sensor),
        {"Content-Disposition": f'attachment; filename="{seq}-{format}.zip"'},
    )


def person_of(request: Request, who: Principal) -> str:
    """Return a unique name of a person; users of the server's own token differ by address."""
    gate: Gate = request.app.state.gate
    address = gate.clients.address(request) if who.shared else ""
    return f"{who.author} {address}"
