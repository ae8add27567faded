"""LZ4 frames (Yann Collet), as ROS bags and MCAP files use them."""

from __future__ import annotations

import struct

from pointbrush.errors import BadInputError

MAGIC = b"\x04\x22\x4d\x18"


def lz4_decompress(name: str, data: bytes, size: int) -> bytes:
    """One frame, to exactly ``size`` bytes; raises BadInputError for data that does not."""
    out = bytearray()
    try:
        if data[:4] != MAGIC:
            raise IndexError
        flags = data[4]
        at = 7 + (8 if flags & 0x08 else 0) + (4 if flags & 0x01 else 0)
        while True:
            (length,) = struct.unpack_from("<I", data, at)
            at += 4
            if length == 0:
                break
            stored, length = length >> 31, length & 0x7FFFFFFF
            block = data[at : at + length]
            if len(block) < length:
                raise IndexError
            if stored:
                out += block
            else:
                _block(block, out, size)
            if len(out) > size:
                raise IndexError
            at += length + (4 if flags & 0x10 else 0)
    except (IndexError, struct.error):
        raise BadInputError(f"{name}: expected {size} bytes of LZ4 data, it is damaged") from None
    if len(out) != size:
        raise BadInputError(f"{name}: expected {size} bytes of LZ4 data, got {len(out)}")
    return bytes(out)


def _block(data: bytes, out: bytearray, size: int) -> None:
    """Append a block to ``out``, which is also the history that copies refer to."""
    at, end = 0, len(data)
    while at < end:
        token = data[at]
        at += 1
        literals = token >> 4
        if literals == 15:
            literals, at = _longer(data, at, literals)
        if at + literals > end:
            raise IndexError
        out += data[at : at + literals]
        at += literals
        if at == end:
            return
        distance = data[at] | data[at + 1] << 8
        at += 2
        length = token & 15
        if length == 15:
            length, at = _longer(data, at, length)
        length += 4
        start = len(out) - distance
        if distance == 0 or start < 0 or len(out) + length > size:
            raise IndexError
        if distance >= length:
            out += out[start : start + length]
        else:
            # The copy overlaps what it writes: the last bytes repeat.
            out += (out[start:] * (length // distance + 1))[:length]


def _longer(data: bytes, at: int, length: int) -> tuple[int, int]:
    while data[at] == 255:
        length += 255
        at += 1
    return length + data[at], at + 1
