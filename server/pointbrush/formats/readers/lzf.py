"""LZF (Marc Lehmann's liblzf), the compression of PCD files."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.errors import BadInputError


def lzf_decompress(name: str, data: bytes, size: int) -> bytes:
    """Decompress to exactly ``size`` bytes; raise BadInputError for other data."""
    out = np.empty(size, np.uint8)
    made, at = _decompress(np.frombuffer(data, np.uint8), out)
    if made < 0:
        raise BadInputError(
            f"{name}: expected LZF data of {size} bytes, it is damaged at compressed byte {at}"
        )
    if made != size:
        raise BadInputError(f"{name}: expected {size} bytes of LZF data, got {made}")
    return out.tobytes()


@compiled
def _decompress(data: NDArray[np.uint8], out: NDArray[np.uint8]) -> tuple[int, int]:
    """Return the bytes written, -1 for damaged data, and the compressed bytes read."""
    at = made = 0
    end, size = len(data), len(out)
    while at < end:
        control = np.int64(data[at])
        at += 1
        if control < 32:
            length = control + 1
            if at + length > end or made + length > size:
                return -1, at
            for _ in range(length):
                out[made] = data[at]
                made += 1
                at += 1
            continue
        length = control >> 5
        if length == 7:
            if at >= end:
                return -1, at
            length += np.int64(data[at])
            at += 1
        length += 2
        if at >= end:
            return -1, at
        start = made - ((control & 31) << 8) - np.int64(data[at]) - 1
        at += 1
        if start < 0 or made + length > size:
            return -1, at
        # Byte by byte: source and target of the copy may overlap, so that the last bytes repeat.
        for step in range(length):
            out[made] = out[start + step]
            made += 1
    return made, at
