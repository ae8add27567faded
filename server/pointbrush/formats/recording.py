"""Files of bags: mapped into memory, and their packed chunks."""

from __future__ import annotations

import bz2
from mmap import ACCESS_READ, mmap
from pathlib import Path

from pointbrush.errors import BadInputError, TooLargeError

MAX_CHUNK = 1 << 31


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
        return reader.read(size + 1)
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from None
