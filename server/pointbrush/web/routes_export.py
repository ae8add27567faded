"""Exports, streamed while they are written."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from typing import Annotated

from fastapi import APIRouter, Query, Response
from fastapi.responses import StreamingResponse

from pointbrush.formats import EXPORTS
from pointbrush.web.context import SequenceId, Ws, one_of
from pointbrush.web.problems import responses

router = APIRouter(tags=["export"])
BINARY = {"schema": {"type": "string", "format": "binary"}}
PIECES = 16
PIECE = 256 << 10
PATIENCE = 60.0
"""Seconds a client may read nothing before its export is given up."""
FrameRange = Annotated[
    str | None, Query(pattern=r"^[0-9]{0,9}(:[0-9]{0,9})?$", description="I:J, J not included")
]


class Pipe:
    """A write-only file whose pieces a response iterates over, a bounded number apart."""

    def __init__(self) -> None:
        self._pieces: queue.Queue[bytes | BaseException | None] = queue.Queue(PIECES)
        self._gathered = bytearray()
        self._closed = threading.Event()

    def write(self, data: bytes) -> int:
        """Take ``data``; raises BrokenPipeError when nobody reads any more."""
        self._gathered += data
        if len(self._gathered) >= PIECE:
            self.flush_piece()
        return len(data)

    def flush(self) -> None:
        """Nothing: pieces leave when they are large enough."""

    def flush_piece(self) -> None:
        """Hand over what has gathered."""
        piece, self._gathered = bytes(self._gathered), bytearray()
        if piece:
            self._put(piece)

    def finish(self, error: BaseException | None) -> None:
        """No more will come; ``error`` is raised in the reader."""
        try:
            if error is None:
                self.flush_piece()
            self._put(error)
        except BrokenPipeError:
            return

    def _put(self, item: bytes | BaseException | None) -> None:
        if self._closed.is_set():
            raise BrokenPipeError("the client has gone")
        try:
            self._pieces.put(item, timeout=PATIENCE)
        except queue.Full:
            raise BrokenPipeError("the client does not read") from None

    def __iter__(self) -> Iterator[bytes]:
        try:
            while (item := self._pieces.get()) is not None:
                if isinstance(item, BaseException):
                    raise item
                yield item
        finally:
            self._closed.set()
            while not self._pieces.empty():
                self._pieces.get_nowait()


@router.get(
    "/sequences/{seq}/export",
    response_class=Response,
    responses={
        200: {"description": "The export", "content": {"application/zip": BINARY}},
        **responses(404),
    },
)
def export_sequence(
    seq: SequenceId,
    workspace: Ws,
    format: Annotated[str, Query(pattern=one_of(EXPORTS))],
    frames: FrameRange = None,
) -> Response:
    """Frames with their labels in the source's order, as a zip."""
    workspace.recording(seq)
    pipe = Pipe()

    def write() -> None:
        try:
            workspace.export(seq, format, pipe, frames)  # type: ignore[arg-type]
        except BaseException as error:
            pipe.finish(error)
        else:
            pipe.finish(None)

    threading.Thread(target=write, name="pointbrush-export", daemon=True).start()
    pieces = iter(pipe)
    # The first piece is awaited here, so that bad input is still answered as a problem.
    first = next(pieces, b"")

    def body() -> Iterator[bytes]:
        yield first
        yield from pieces

    name = f'attachment; filename="{seq}-{format}.zip"'
    headers = {"Content-Disposition": name}
    return StreamingResponse(body(), media_type="application/zip", headers=headers)
