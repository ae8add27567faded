"""What bags of several kinds have in common: topics, their rate, and packed chunks."""

from __future__ import annotations

import bz2
from collections.abc import Mapping
from dataclasses import dataclass
from mmap import ACCESS_READ, mmap
from pathlib import Path

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats.lz4 import lz4_decompress

MAX_CHUNK = 1 << 31


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic with point clouds: ``count`` messages (0 = not known) from ``start`` to ``end``."""

    name: str
    count: int = 0
    start: float = 0.0
    end: float = 0.0

    @property
    def fps(self) -> float | None:
        """Messages per second, where count and times tell."""
        if self.count < 2 or self.end <= self.start:
            return None
        rate = (self.count - 1) / (self.end - self.start)
        # Recorded sensors run at whole rates; the first and last message blur it a little.
        near = abs(rate - round(rate)) < 0.03 * rate and round(rate) > 0
        return float(round(rate)) if near else round(rate, 3)


def map_recording(path: Path, magic: bytes, kind: str) -> mmap:
    """A file of this ``kind`` as memory; raises BadInputError when it does not begin so."""
    with path.open("rb") as file:
        if path.stat().st_size == 0:
            raise BadInputError(f"{path.name}: expected {kind}, got an empty file (0 bytes)")
        data = mmap(file.fileno(), 0, access=ACCESS_READ)
    start = data[: len(magic)]
    if start != magic:
        data.close()
        raise BadInputError(f"{path.name}: expected {kind}, got another file")
    return data


def choose_topic(name: str, clouds: Mapping[str, int], types: Mapping[str, str]) -> str:
    """The topic with most point clouds of those in ``types``, topic → type of its messages.

    Raises BadInputError naming topics and types when none has point clouds.
    """
    if not clouds:
        named = [f"{topic} ({types[topic] or 'no type'}){_what(types[topic])}" for topic in types]
        seen = ", ".join(sorted(named)[:8]) or "no messages"
        raise BadInputError(f"{name}: expected messages of type PointCloud2, got {seen}")
    return min(clouds, key=lambda topic: (-clouds[topic], topic))


def _what(kind: str) -> str:
    """A word on messages that users take for point clouds."""
    if kind.endswith("CustomMsg"):
        return ", a Livox driver's own: record with xfer_format 0, or convert them"
    if kind.endswith(("VelodyneScan", "PacketMsg", "Packets", "LidarScan")):
        return ", packets of a driver: replay them through it, and record its points"
    return ""


def unpack_chunk(name: str, packed: bytes, compression: str, size: int) -> bytes:
    """A chunk of ``size`` bytes; raises BadInputError when damaged, TooLargeError beyond 2 GiB."""
    if size > MAX_CHUNK:
        raise TooLargeError(f"{name}: expected chunks of at most {MAX_CHUNK} bytes, got {size}")
    if compression in ("", "none"):
        return packed
    if compression == "lz4":
        return lz4_decompress(name, packed, size)
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


def _zstd(packed: bytes, size: int) -> bytes:
    import zstandard

    try:
        reader = zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(packed)
        return reader.read(size + 1)
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from None
