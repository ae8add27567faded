"""MCAP files with PointCloud2 messages of ROS 1 or ROS 2."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from mmap import mmap
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.ros.bag import (
    Bag,
    BagMessage,
    Topic,
    map_recording,
    read_bag,
    unpack_chunk,
    unpack_message,
)

MAGIC = b"\x89MCAP0\r\n"
ENCODINGS = ("cdr", "ros1")
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS, DATA_END = 2, 3, 4, 5, 6, 0x0B, 0x0F


@dataclass
class _Channels:
    """Schemas, and (topic, type, encoding) of each channel of the file ``name``."""

    name: str
    schemas: dict[int, str] = field(default_factory=dict)
    channels: dict[int, tuple[str, str, str]] = field(default_factory=dict)

    def add(self, operation: int, content: bytes) -> None:
        """Record a schema or a channel; raise BadInputError for a truncated one."""
        try:
            self._add(operation, content)
        except struct.error:
            raise BadInputError(f"{self.name}: expected a record, it is cut off") from None

    def _add(self, operation: int, content: bytes) -> None:
        if operation == SCHEMA:
            (number,) = struct.unpack_from("<H", content)
            self.schemas[number] = _text(content, 2)[0]
        elif operation == CHANNEL:
            number, schema = struct.unpack_from("<HH", content)
            topic, at = _text(content, 4)
            self.channels[number] = (topic, self.schemas.get(schema, ""), _text(content, at)[0])

    def topics(self, counts: Mapping[int, int]) -> list[Topic]:
        """The topics, with the numbers of messages of their channels."""
        found: dict[str, Topic] = {}
        for number, (topic, kind, encoding) in self.channels.items():
            known = found.get(topic, Topic(topic, kind if encoding in ENCODINGS else encoding))
            found[topic] = replace(known, count=known.count + counts.get(number, 0))
        return list(found.values())


def topics_of(path: Path) -> list[Topic]:
    """List a file's topics, from its summary; raises BadInputError when cut off or damaged."""
    with map_recording(path, MAGIC, "an MCAP file") as data:
        known = _Channels(path.name)
        counts: Counter[int] = Counter()
        summary = _summary_start(path.name, data)
        if summary:
            for operation, content in _records(path.name, data, summary, len(data) - len(MAGIC)):
                known.add(operation, content)
                if operation == STATISTICS and len(content) >= 46:
                    (length,) = struct.unpack_from("<I", content, 42)
                    for at in range(46, min(46 + length, len(content) - 9), 10):
                        number, count = struct.unpack_from("<HQ", content, at)
                        counts[number] += count
        if not counts:
            for channel, _, _ in _messages(path.name, data, known):
                counts[channel] += 1
    return known.topics(counts)


def messages_of(path: Path, topic: str) -> Iterator[BagMessage]:
    """Messages of a topic as stored; raises BadInputError when cut off or damaged."""
    with map_recording(path, MAGIC, "an MCAP file") as data:
        known = _Channels(path.name)
        for channel, time, message in _messages(path.name, data, known):
            name, _, encoding = known.channels.get(channel, ("", "", ""))
            if name == topic and encoding in ENCODINGS:
                yield BagMessage(encoding, time, unpack_message(path.name, message))


BAG = Bag(topics_of, messages_of)
read_mcap = partial(read_bag, BAG)


def _summary_start(name: str, data: mmap) -> int:
    """Position of the summary, 0 where there is none; raises BadInputError for a cut off file."""
    at = len(data) - len(MAGIC) - 29
    if at < len(MAGIC) or data[-len(MAGIC) :] != MAGIC or data[at] != FOOTER:
        raise BadInputError(f"{name}: expected an MCAP footer at the end, the file is cut off")
    (summary,) = struct.unpack_from("<Q", data, at + 9)
    if summary >= len(data):
        raise BadInputError(f"{name}: expected a summary within the file, got {summary}")
    return int(summary)


def _messages(name: str, data: mmap, known: _Channels) -> Iterator[tuple[int, float, bytes]]:
    """(channel, time, message) of every message, within chunks or not."""
    for operation, content in _records(name, data, len(MAGIC), len(data) - len(MAGIC)):
        if operation == DATA_END:
            return
        if operation == CHUNK:
            chunk = _chunk(name, content)
            for inner, part in _records(name, chunk, 0, len(chunk)):
                yield from _message(name, inner, part, known)
        else:
            yield from _message(name, operation, content, known)


def _chunk(name: str, content: bytes) -> bytes:
    try:
        (size,) = struct.unpack_from("<Q", content, 16)
        compression, at = _text(content, 28)
        (length,) = struct.unpack_from("<Q", content, at)
    except struct.error:
        raise BadInputError(f"{name}: expected a chunk, it is cut off") from None
    return unpack_chunk(name, content[at + 8 : at + 8 + length], compression, size)


def _message(
    name: str, operation: int, content: bytes, known: _Channels
) -> Iterator[tuple[int, float, bytes]]:
    known.add(operation, content)
    if operation == MESSAGE:
        if len(content) < 22:
            raise BadInputError(f"{name}: expected a message, it is cut off")
        channel, _, time = struct.unpack_from("<HIQ", content)
        yield channel, time / 1e9, content[22:]


def _records(name: str, data: bytes | mmap, at: int, end: int) -> Iterator[tuple[int, bytes]]:
    """(operation, content) of the records in a range."""
    while at < end:
        if at + 9 > end:
            raise BadInputError(f"{name}: expected a record at byte {at}, the file is cut off")
        operation, length = struct.unpack_from("<BQ", data, at)
        if at + 9 + length > end:
            raise BadInputError(
                f"{name}: expected a record of {length} bytes at byte {at}, the file is cut off"
            )
        yield operation, bytes(data[at + 9 : at + 9 + length])
        at += 9 + length


def _text(content: bytes, at: int) -> tuple[str, int]:
    (length,) = struct.unpack_from("<I", content, at)
    return content[at + 4 : at + 4 + length].decode("utf-8", "replace"), at + 4 + length
