"""MCAP files with PointCloud2 messages of ROS 1 or ROS 2."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from mmap import mmap
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.pointcloud2 import TYPES, frame_of_message
from pointbrush.formats.recording import Topic, choose_topic, map_recording, unpack_chunk
from pointbrush.frame import PointFrame

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS, DATA_END = 2, 3, 4, 5, 6, 0x0B, 0x0F


@dataclass
class _Channels:
    """Schemas, and (topic, type, encoding) of each channel of the file ``name``."""

    name: str
    schemas: dict[int, str] = field(default_factory=dict)
    channels: dict[int, tuple[str, str, str]] = field(default_factory=dict)

    def add(self, operation: int, content: bytes) -> None:
        """Take note of a schema or a channel; raises BadInputError for one that is cut off."""
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

    def clouds(self) -> dict[int, str]:
        """Channel → topic of those with point clouds."""
        return {
            number: topic
            for number, (topic, kind, encoding) in self.channels.items()
            if kind in TYPES and encoding in ("cdr", "ros1")
        }


def read_mcap(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """The PointCloud2 messages of the topic that has most, in recorded order.

    Raises BadInputError for a file without such messages, cut off or damaged.
    """
    topic = survey_mcap(path).name
    with map_recording(path, MAGIC, "an MCAP file") as data:
        known = _Channels(path.name)
        for channel, time, message in _messages(path.name, data, known):
            if known.clouds().get(channel) == topic:
                encoding = known.channels[channel][2]
                yield frame_of_message(f"{path.name} {topic}", message, encoding, time, options)


def survey_mcap(path: Path) -> Topic:
    """The topic that is read, its number of messages and their times; from the summary.

    Raises BadInputError when no topic has point clouds.
    """
    with map_recording(path, MAGIC, "an MCAP file") as data:
        known = _Channels(path.name)
        counts: Counter[int] = Counter()
        start = end = 0.0
        summary = _summary_start(path.name, data)
        if summary:
            for operation, content in _records(path.name, data, summary, len(data) - len(MAGIC)):
                known.add(operation, content)
                if operation == STATISTICS and len(content) >= 46:
                    first, last, length = struct.unpack_from("<QQI", content, 26)
                    start, end = first / 1e9, last / 1e9
                    for at in range(46, min(46 + length, len(content) - 9), 10):
                        number, count = struct.unpack_from("<HQ", content, at)
                        counts[number] += count
        if not counts:
            times = []
            for channel, time, _ in _messages(path.name, data, known):
                counts[channel] += 1
                times.append(time)
            start, end = (min(times), max(times)) if times else (0.0, 0.0)
    clouds: Counter[str] = Counter()
    for number, topic in known.clouds().items():
        clouds[topic] += counts[number]
    topic = choose_topic(
        path.name, clouds, {topic: kind for topic, kind, _ in known.channels.values()}
    )
    return Topic(topic, clouds[topic], start, end)


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
