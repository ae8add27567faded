"""ROS 1 bags (format 2.0) with PointCloud2 messages."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from mmap import mmap
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.ros.bag import Bag, BagMessage, Topic, map_recording, read_bag, unpack_chunk

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, BAG_HEADER, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 5, 6, 7


@dataclass
class _Index:
    """Connections and the numbers of their messages, as the end of a bag lists them."""

    topics: dict[int, str] = field(default_factory=dict)
    types: dict[str, str] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)

    def connect(self, header: dict[str, bytes], data: bytes) -> None:
        number = _u32(header, "conn")
        topic = header.get("topic", b"").decode("utf-8", "replace")
        self.topics[number] = topic
        self.types[topic] = _fields(data).get("type", b"").decode("utf-8", "replace")


def topics_of(path: Path) -> list[Topic]:
    """List a bag's topics, from its index; raises BadInputError for a bag cut off or damaged."""
    with map_recording(path, MAGIC, "a bag of format 2.0") as data:
        index = _Index()
        for _, operation, header, _ in _records(path.name, data, len(MAGIC), len(data)):
            if operation == BAG_HEADER:
                end = _u64(header, "index_pos")
                if end == 0:
                    # The bag was not closed properly: scan the chunks instead.
                    index = _scanned(path.name, data)
                    break
                if not len(MAGIC) < end <= len(data):
                    raise BadInputError(
                        f"{path.name}: expected an index within {len(data)} bytes, got one at "
                        f"{end}; the bag is cut off"
                    )
                _read_index(path.name, data, end, index)
                break
    counts: Counter[str] = Counter()
    for number, topic in index.topics.items():
        counts[topic] += index.counts[number]
    return [Topic(topic, kind, counts[topic]) for topic, kind in index.types.items()]


def messages_of(path: Path, topic: str) -> Iterator[BagMessage]:
    """Messages of a topic as stored; raises BadInputError for a bag cut off or damaged."""
    with map_recording(path, MAGIC, "a bag of format 2.0") as data:
        index = _Index()
        for number, message, time in _messages(path.name, data, index):
            if index.topics.get(number) == topic:
                yield BagMessage("ros1", time, message)


BAG = Bag(topics_of, messages_of)
read_rosbag1 = partial(read_bag, BAG)


def _read_index(name: str, data: mmap, start: int, index: _Index) -> None:
    for _, operation, header, content in _records(name, data, start, len(data)):
        if operation == CONNECTION:
            index.connect(header, content)
        elif operation == CHUNK_INFO:
            for at in range(0, len(content) - 7, 8):
                number, count = struct.unpack_from("<II", content, at)
                index.counts[number] += count


def _scanned(name: str, data: mmap) -> _Index:
    index = _Index()
    for number, _, _ in _messages(name, data, index):
        index.counts[number] += 1
    return index


def _messages(name: str, data: mmap, index: _Index) -> Iterator[tuple[int, bytes, float]]:
    """(connection, message, time) of every message, within chunks or not."""
    for _, operation, header, content in _records(name, data, len(MAGIC), len(data)):
        if operation == CHUNK:
            compression = header.get("compression", b"none").decode("ascii", "replace")
            chunk = unpack_chunk(name, content, compression, _u32(header, "size"))
            for _, inner, fields, part in _records(name, chunk, 0, len(chunk)):
                yield from _message(inner, fields, part, index)
        else:
            yield from _message(operation, header, content, index)


def _message(
    operation: int, header: dict[str, bytes], content: bytes, index: _Index
) -> Iterator[tuple[int, bytes, float]]:
    if operation == CONNECTION:
        index.connect(header, content)
    elif operation == MESSAGE:
        yield _u32(header, "conn"), content, _time(header, "time")


def _records(
    name: str, data: bytes | mmap, at: int, end: int
) -> Iterator[tuple[int, int, dict[str, bytes], bytes]]:
    """(position, operation, header, data) of the records in a range."""
    while at < end:
        try:
            (length,) = struct.unpack_from("<I", data, at)
            header = _fields(bytes(data[at + 4 : at + 4 + length]))
            (size,) = struct.unpack_from("<I", data, at + 4 + length)
        except struct.error:
            raise BadInputError(
                f"{name}: expected a record at byte {at}, the bag is cut off"
            ) from None
        start = at + 8 + length
        if start + size > end:
            raise BadInputError(
                f"{name}: expected a record of {size} bytes at byte {at}, the bag is cut off"
            )
        operation = header.get("op", b"")
        if len(operation) != 1:
            raise BadInputError(f"{name}: expected a record at byte {at}, it is damaged")
        yield at, operation[0], header, bytes(data[start : start + size])
        at = start + size


def _fields(data: bytes) -> dict[str, bytes]:
    fields: dict[str, bytes] = {}
    at = 0
    while at + 4 <= len(data):
        (length,) = struct.unpack_from("<I", data, at)
        key, _, value = data[at + 4 : at + 4 + length].partition(b"=")
        fields[key.decode("ascii", "replace")] = value
        at += 4 + length
    return fields


def _u32(header: dict[str, bytes], key: str) -> int:
    return int.from_bytes(header.get(key, b"")[:4], "little")


def _u64(header: dict[str, bytes], key: str) -> int:
    return int.from_bytes(header.get(key, b"")[:8], "little")


def _time(header: dict[str, bytes], key: str) -> float:
    value = header.get(key, bytes(8)).ljust(8, b"\0")
    seconds, nanoseconds = struct.unpack_from("<II", value)
    return float(seconds + nanoseconds / 1e9)
