"""Bags of any kind: their files and chunks, and their point clouds in the order of time."""

from __future__ import annotations

import bz2
import logging
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice
from mmap import ACCESS_READ, mmap
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.ros.message import (
    COMPRESSED,
    IMAGE,
    TYPES,
    frame_of_message,
    head_of_message,
    kind_of,
)
from pointbrush.formats.times.time_order import order_by_time
from pointbrush.frame import PointFrame

log = logging.getLogger(__name__)
SENSOR = "#"
"""Separator of a topic and the frame id of a sensor on it; topics cannot contain it."""
NAMED = 8
"""Most topics in the list of an error."""
STAMPS, RECORDED = "the stamps of the messages", "the times of recording"
MAX_CHUNK = 1 << 31
BLOCK = 1 << 20
"""Bytes that are unpacked at once."""
ZSTD = b"\x28\xb5\x2f\xfd"
"""Beginning of a message that rosbag2 has compressed; no other message begins so."""


def map_recording(path: Path, magic: bytes, kind: str) -> mmap:
    """Map a file of this ``kind`` into memory; raise BadInputError if its magic is wrong."""
    with path.open("rb") as file:
        if path.stat().st_size == 0:
            raise BadInputError(f"{path.name}: expected {kind}, got an empty file (0 bytes)")
        data = mmap(file.fileno(), 0, access=ACCESS_READ)
    start = data[: len(magic)]
    if start != magic:
        data.close()
        raise BadInputError(f"{path.name}: expected {kind}, got another file")
    return data


def unpack_chunk(name: str, packed: bytes, compression: str, size: int) -> bytes:
    """A chunk of ``size`` bytes; raises BadInputError when damaged, TooLargeError beyond 2 GiB."""
    if size > MAX_CHUNK:
        raise TooLargeError(f"{name}: expected chunks of at most {MAX_CHUNK} bytes, got {size}")
    if compression in ("", "none"):
        return packed
    if compression == "lz4":
        return _lz4(name, packed, size)
    try:
        if compression == "bz2":
            data = bz2.BZ2Decompressor().decompress(packed, size + 1)
        elif compression == "zstd":
            data = _zstd(packed, size)
        else:
            raise BadInputError(f"{name}: expected chunks packed by lz4, bz2 or zstd, got others")
    except (OSError, ValueError) as error:
        if isinstance(error, BadInputError):
            raise
        raise BadInputError(f"{name}: expected a whole {compression} chunk, {error}") from None
    if len(data) != size:
        raise BadInputError(f"{name}: expected a chunk of {size} bytes, got {len(data)}")
    return data


def unpack_message(name: str, message: bytes) -> bytes:
    """Return a message, decompressed if the recorder compressed it; raise as ``unpack_chunk``."""
    if not message.startswith(ZSTD):
        return message
    import zstandard

    try:
        size = zstandard.frame_content_size(message)
        if size < 0:  # unknown size
            return _zstd(message, MAX_CHUNK)
    except (zstandard.ZstdError, ValueError) as error:
        raise BadInputError(f"{name}: expected a whole zstd message, {error}") from None
    return unpack_chunk(name, message, "zstd", size)


def _lz4(name: str, packed: bytes, size: int) -> bytes:
    import lz4.frame

    try:
        decoder = lz4.frame.LZ4FrameDecompressor()
        data: bytes = decoder.decompress(packed, max_length=size + 1)
    except (RuntimeError, EOFError) as error:
        raise BadInputError(f"{name}: expected a whole LZ4 frame, {error}") from None
    if len(data) != size or not decoder.eof:
        raise BadInputError(f"{name}: expected a whole LZ4 frame of {size} bytes, got {len(data)}")
    return data


def _zstd(packed: bytes, size: int) -> bytes:
    import zstandard

    try:
        reader = zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(packed)
        # In blocks, because one read allocates the memory of its whole size.
        blocks = iter(partial(reader.read, BLOCK), b"")
        return b"".join(islice(blocks, size // BLOCK + 1))
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from None


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic of a bag: the type of its messages, and their number."""

    name: str
    type: str
    count: int = 0

    @property
    def has_clouds(self) -> bool:
        """Whether its messages are point clouds that are read."""
        return self.type in TYPES


@dataclass(frozen=True, slots=True)
class BagMessage:
    """A stored message; ``time``: time of its recording, seconds."""

    encoding: str
    time: float
    data: bytes


@dataclass(frozen=True, slots=True)
class Bag:
    """A kind of bag: ``topics`` lists topics of a file, ``messages`` yields a topic's messages."""

    topics: Callable[[Path], list[Topic]]
    messages: Callable[[Path, str], Iterator[BagMessage]]


@dataclass(frozen=True, slots=True, eq=False)
class Clouds:
    """The point clouds of a bag that make a recording.

    ``order``: numbers of the messages of ``topic`` that are its frames, in the order of time;
    ``order_from`` describes the source of the order.  ``stamps`` and ``recorded``: their stamps and
    times of recording in that order, seconds.  ``sensor``: their frame id; ``sensors``: number of
    messages of each frame id on the topic.
    """

    topic: str
    topics: tuple[Topic, ...]
    order: NDArray[np.int64]
    order_from: str
    stamps: NDArray[np.float64]
    recorded: NDArray[np.float64]
    sensor: str
    sensors: dict[str, int]


def find_clouds(bag: Bag, path: Path, wanted: str | None) -> Clouds:
    """Choose the topic ``wanted`` ("topic" or "topic#frame_id"), else the one with most clouds.

    Warnings list the other topics with clouds, and the other sensors on the topic, which have fewer
    messages.  Raises BadInputError naming topics and types if there is no such topic.
    """
    topics = bag.topics(path)
    name, _, sensor = (wanted or "").partition(SENSOR)
    topic = _choose(path.name, topics, name)
    heads = [
        (*head_of_message(f"{path.name} {topic}", message, "PointCloud2"), message.time)
        for message in bag.messages(path, topic)
    ]
    sensors = Counter(frame_id for _, frame_id, _ in heads)
    if sensor and sensor not in sensors:
        raise BadInputError(
            f"{path.name}: expected a sensor of {topic}: {', '.join(sorted(sensors))}, got "
            f"{sensor!r}"
        )
    _warn_of_others(path.name, topics, topic, name)
    if not sensor and sensors:
        sensor = min(sensors, key=lambda each: (-sensors[each], each))
        others = [f"{topic}{SENSOR}{each}" for each in sorted(sensors) if each != sensor]
        if others:
            log.warning(
                "%s: several sensors publish on %s: '%s' is read; choose another by topic: %s",
                path.name, topic, sensor, ", ".join(others),
            )  # fmt: skip
    taken = np.array([i for i, head in enumerate(heads) if head[1] == sensor], np.int64)
    stamps, recorded = (np.array([heads[i][k] for i in taken], np.float64) for k in (0, 2))
    where = f"{path.name} {topic}: "
    found = order_by_time(stamps.tolist(), STAMPS, "in the order of recording", where=where)
    order = np.array(found.places, np.int64)
    return Clouds(
        topic, tuple(topics), taken[order], found.source, stamps[order], recorded[order], sensor,
        dict(sensors),
    )  # fmt: skip


def read_clouds(bag: Bag, found: Clouds, path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """Yield frames in the order of stamps; a message waits in memory for the earlier ones."""
    place = {number: at for at, number in enumerate(found.order.tolist())}
    waiting: dict[int, BagMessage] = {}
    following = 0
    for number, message in enumerate(bag.messages(path, found.topic)):
        if number not in place:
            continue
        waiting[place[number]] = message
        while following in waiting:
            yield frame_of_message(f"{path.name} {found.topic}", waiting.pop(following), options)
            following += 1


def read_bag(bag: Bag, path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """The clouds of one file; see ``find_clouds``."""
    yield from read_clouds(bag, find_clouds(bag, path, options.chosen.topic), path, options)


def _choose(name: str, topics: Sequence[Topic], wanted: str) -> str:
    if wanted:
        found = next((topic for topic in topics if topic.name == wanted), None)
        if found is not None and found.has_clouds:
            return wanted
        got = (
            f"{wanted!r}"
            if found is None
            else f"{wanted} ({found.type or 'no type'}){_what(found.type)}"
        )
        named = ", ".join(sorted(topic.name for topic in topics if topic.has_clouds)) or "none"
        raise BadInputError(f"{name}: expected a topic with PointCloud2 ({named}), got {got}")
    clouds = [topic for topic in topics if topic.has_clouds]
    if not clouds:
        listed = sorted(f"{t.name} ({t.type or 'no type'}){_what(t.type)}" for t in topics)
        seen = ", ".join(listed[:NAMED]) or "no messages"
        raise BadInputError(f"{name}: expected messages of type PointCloud2, got {seen}")
    return min(clouds, key=lambda topic: (-topic.count, topic.name)).name


def _warn_of_others(name: str, topics: Sequence[Topic], topic: str, wanted: str) -> None:
    """Warn of the other topics with clouds if the user chose none."""
    clouds = [each for each in topics if each.has_clouds and each.count and each.name != topic]
    others = [f"{each.name} ({each.count})" for each in clouds]
    if others and not wanted:
        log.warning(
            "%s: of the topics with clouds, %s is read; left out, by their number of clouds: %s; "
            "to read another one, name its topic (--topic)",
            name, topic, ", ".join(others[:NAMED]),
        )  # fmt: skip


def _what(kind: str) -> str:
    """Return an explanation of messages that resemble point clouds."""
    if kind_of(kind) in (IMAGE, COMPRESSED):
        return ", pictures: turn depth images into points with depth_image_proc"
    if kind.endswith("CustomMsg"):
        return ", a Livox driver's own: record with xfer_format 0, or convert them"
    if kind.endswith(("VelodyneScan", "PacketMsg", "Packets", "LidarScan")):
        return ", packets of a driver: replay them through it, and record its points"
    return ""
