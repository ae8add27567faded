"""Messages to and from bytes: one msgpack map each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from pointbrush.errors import BadInputError
from pointbrush.labels import Delta, FrameValues
from pointbrush.sequences import StoredFrame
from pointbrush.streaming.messages import ClientMessage, Message
from pointbrush.streaming.messages.values import RUN_BYTES
from pointbrush.streaming.shared.status import MalformedError
from pointbrush.values.frames import Chunk
from pointbrush.values.validation import describe

DELETED = 65535
"""Wire value of a deleted point."""
LONGEST = 65_536
"""Most items of an array in a client's message."""
_client: TypeAdapter[ClientMessage] = TypeAdapter(ClientMessage)


def unpack(data: bytes) -> dict[Any, Any]:
    """Return the map of a client's message; raise MalformedError if it is not a map."""
    try:
        content = msgpack.unpackb(
            data,
            max_array_len=LONGEST,
            max_map_len=64,
            max_ext_len=0,
            max_bin_len=RUN_BYTES,
            max_str_len=4096,
        )
    # msgpack raises its own errors, ValueError, TypeError or UnicodeDecodeError on junk.
    except Exception as error:
        raise MalformedError(f"message: expected a msgpack map, got {error}"[:300]) from None
    if not isinstance(content, dict):
        raise MalformedError(f"message: expected a map, got {type(content).__name__}")
    return content


def decode(data: bytes) -> ClientMessage:
    """Return a client's message; raise MalformedError or BadInputError."""
    return check(unpack(data))


def check(content: dict[Any, Any]) -> ClientMessage:
    """Return a client's message from its map; raise BadInputError if no model fits."""
    try:
        return _client.validate_python(content)
    except ValidationError as error:
        raise BadInputError(describe(error.errors(include_url=False))) from None


def encode(message: Message) -> bytes:
    """Return the bytes of a server's message."""
    packed: bytes = msgpack.packb(message.model_dump())
    return packed


def encode_beginning(message: Message, without: Sequence[str]) -> bytes:
    """Encode a message without its last fields ``without``; ``encode_end`` encodes them."""
    fields = message.model_dump()
    packer = msgpack.Packer(autoreset=False)
    packer.pack_map_header(len(fields))
    for name, value in fields.items():
        if name not in without:
            packer.pack(name)
            packer.pack(value)
    return bytes(packer.bytes())


def encode_end(fields: Mapping[str, Any]) -> bytes:
    """Encode the last fields of a message of ``encode_beginning``."""
    packer = msgpack.Packer(autoreset=False)
    for name, value in fields.items():
        packer.pack(name)
        packer.pack(value)
    return bytes(packer.bytes())


def encode_frame(
    sequence: str, frame: StoredFrame, first: int, stop: int, *, final: bool
) -> tuple[bytes, memoryview]:
    """Encode chunks [first, stop) as a ``frame`` message in two consecutive parts.

    The second part holds the points: a view of the memory map, sent without a copy.
    """
    chunks = frame.chunks[first:stop]
    start = chunks[0].offset if chunks else 0
    rows = [_point_row(chunk, chunk.offset - start, chunk.nbytes) for chunk in chunks]
    return _points("frame", sequence, frame, rows, frame.wire(first, stop), final=final)


def encode_depth(
    sequence: str, frame: StoredFrame, first: int, stop: int, *, final: bool
) -> tuple[bytes, memoryview]:
    """Encode chunks as parts of the frame's depth image: a ``depth`` message.

    Chunks of sensors without a depth image are points, as in a ``frame`` message.
    """
    starts = [frame.depth_start(chunk) for chunk in range(first, stop + 1)]
    rows = [
        (_row if frame.is_band(chunk.index) else _point_row)(chunk, start - starts[0], end - start)
        for chunk, (start, end) in zip(frame.chunks[first:stop], pairwise(starts), strict=True)
    ]
    return _points("depth", sequence, frame, rows, frame.depth(first, stop), final=final)


def _points(
    kind: str,
    sequence: str,
    frame: StoredFrame,
    rows: list[dict[str, Any]],
    data: memoryview,
    *,
    final: bool,
) -> tuple[bytes, memoryview]:
    packer = msgpack.Packer(autoreset=False)
    packer.pack_map_header(7)
    for name, value in (
        ("type", kind),
        ("sequence", sequence),
        ("frame", frame.index),
        ("total", frame.count),
        ("final", final),
        ("chunks", rows),
    ):
        packer.pack(name)
        packer.pack(value)
    packer.pack("data")
    return packer.bytes() + b"\xc6" + len(data).to_bytes(4, "big"), data


def _point_row(chunk: Chunk, offset: int, nbytes: int) -> dict[str, Any]:
    return _row(chunk, offset, nbytes, origin=chunk.origin, scale=chunk.scale)


def _row(chunk: Chunk, offset: int, nbytes: int, **grid: Any) -> dict[str, Any]:
    sensor = {} if chunk.sensor is None else {"sensor": chunk.sensor}
    return {
        "index": chunk.index,
        "level": chunk.level,
        "first": chunk.first,
        "count": chunk.count,
        "offset": offset,
        "nbytes": nbytes,
        **grid,
        **sensor,
        "lo": chunk.lo,
        "hi": chunk.hi,
    }


def encode_whole(sequence: str, frame: int, first: int, values: FrameValues) -> bytes:
    """Encode the values of a run of points as an ``annotation`` message, run-length encoded."""
    shown = np.where(values.deleted, np.uint16(DELETED), values.label)
    starts = np.flatnonzero(np.concatenate(([True], shown[1:] != shown[:-1])))[: len(shown)]
    lengths = np.diff(starts, append=len(shown))
    head = _Head(sequence, frame, values.revision, None, first=first, count=len(shown))
    return _annotation(head, lengths, shown[starts])


def encode_delta(
    sequence: str, frame: int, revision: int, base: int, delta: Delta, edit: str, author: str
) -> bytes:
    """Encode a commit's part in one frame as an ``annotation`` message."""
    shown = np.where(delta.deleted, np.uint16(DELETED), delta.label)
    head = _Head(sequence, frame, revision, base, edit, author)
    return _annotation(head, delta.indices, _single(shown))


def encode_provisional(
    sequence: str, frame: int, revision: int, numbers: NDArray[Any], labels: NDArray[Any]
) -> bytes:
    """Encode a provisional result of a tracking run as an ``annotation`` message."""
    head = _Head(sequence, frame, revision, revision, provisional=True)
    return _annotation(head, numbers, _single(labels))


def _single(values: NDArray[Any]) -> NDArray[Any]:
    """Return one value if all values are equal, otherwise all of them."""
    return values[:1] if len(values) > 1 and (values == values[0]).all() else values


@dataclass(frozen=True)
class _Head:
    """Fields of an ``annotation`` message in the order of the wire, without its arrays."""

    sequence: str
    frame: int
    revision: int
    base: int | None
    edit: str | None = None
    author: str | None = None
    provisional: bool = False
    first: int = 0
    count: int = 0


def _annotation(head: _Head, lengths: NDArray[Any], values: NDArray[Any]) -> bytes:
    arrays = {
        "lengths": lengths.astype("<u4").tobytes(),
        "values": values.astype("<u2").tobytes(),
    }
    packed: bytes = msgpack.packb({"type": "annotation"} | vars(head) | arrays)
    return packed
