"""Coordinates of an octree's points, packed without loss."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.frame import PointFrame
from pointbrush.sequences.octree.packed import PACKED, WIDTH, Packed

_WORD_BITS = 64
_SAMPLE = 4096
"""Points by which decimal coordinates are recognised."""
_MOST_DECIMALS = {4: 4, 8: 6}
"""Most decimals to look for by the bytes of a float; with more, every float32 would match."""
_MOST_WORDS = 3
"""Most words of a point: its coordinates with all their bits."""

Which = slice | NDArray[np.integer[Any]]


def scaling_of(frame: PointFrame) -> NDArray[np.float64]:
    """Return scale, offset and divisor (3, 3) of a source's integers by axis, zeros for floats.

    A coordinate is ``whole × scale / divisor + offset``, which gives decimals exactly.
    """
    some = frame.xyz[:: max(len(frame) // _SAMPLE, 1)]
    if frame.scaling is not None:
        scale, offset = frame.scaling.scale, frame.scaling.offset
        # The import may have changed the unit or rotated the points.
        kept = np.rint((some - offset) / scale) * scale + offset == some
        if kept.mean() > 1 / 2:
            return np.array([scale, offset, np.ones(3)])
    divisors = [_decimals(some[:, axis]) for axis in range(3)]
    return np.array([[float(divisor > 0) for divisor in divisors], np.zeros(3), divisors])


def _decimals(values: NDArray[Any]) -> float:
    """Return the least power of ten that makes values (N,) whole, or 0 for too many decimals."""
    for power in range(_MOST_DECIMALS[values.dtype.itemsize] + 1):
        divisor = 10.0**power
        with np.errstate(over="ignore"):  # infinities, which match no coordinate
            whole = np.rint(values.astype(np.float64) * divisor)
        if np.array_equal((whole / divisor).astype(values.dtype), values):
            return divisor
    return 0.0


def pack_coordinates(
    source: NDArray[Any], scaling: NDArray[np.float64], first: NDArray[np.int64]
) -> Packed:
    """Pack source coordinates (N, 3) of the blocks ``first[b]:first[b + 1]``."""
    # Imported on first use: loading compiled loops takes long, and only an import needs them.
    from pointbrush.sequences.octree.loops import pack

    source, blocks = np.ascontiguousarray(source), len(first) - 1
    base, bits = np.empty((blocks, 3), np.int64), np.empty((blocks, 3), np.uint8)
    words = np.zeros(_MOST_WORDS * len(source) + blocks, np.uint64)
    used = pack(source, _patterns(source), scaling, first, base, bits, words)
    return Packed(words[:used].copy(), base, bits)


def load_loops() -> None:
    """Load the compiled loops, which takes half a second, before the first request needs them."""
    import_module("pointbrush.sequences.octree.loops")


def _patterns(source: NDArray[Any]) -> NDArray[np.signedinteger[Any]]:
    """The same memory as integers."""
    return source.view(np.dtype(f"i{source.dtype.itemsize}"))


class Coordinates:
    """Packed coordinates (N, 3): ``coordinates[numbers]`` are local ones, float32 metres.

    Only the requested points are unpacked.
    """

    def __init__(
        self,
        arrays: Mapping[str, NDArray[Any]],
        meta: Mapping[str, Any],
        shift: NDArray[np.float64],
    ) -> None:
        """``arrays`` and ``meta`` are the frame's; raises ValueError when they do not fit."""
        packed = Packed(*(arrays[name] for name in PACKED))
        self._packed, self._first, self._shift = packed, arrays["block_first"], shift
        self._dtype: np.dtype[Any] = np.dtype(meta["dtype"])
        self._scaling = np.array(meta["scaling"], np.float64)
        counts = np.diff(self._first)
        point_bits = (packed.bits & WIDTH).sum(axis=1, dtype=np.int64)
        words = -(-counts * point_bits // _WORD_BITS)
        self._word = np.concatenate([[0], np.cumsum(words)]).astype(np.int64)
        if (
            (counts < 0).any()
            or self._first[0] != 0
            or packed.base.shape != packed.bits.shape
            or packed.bits.shape != (len(counts), 3)
            or self._scaling.shape != (3, 3)
            or point_bits.max(initial=0) > _MOST_WORDS * _WORD_BITS
            or self._word[-1] != len(packed.words)
        ):
            raise ValueError("packed coordinates that do not fit their blocks")

    def __len__(self) -> int:
        return int(self._first[-1])

    def __getitem__(self, which: Which) -> NDArray[np.float32]:
        """Local coordinates (K, 3) of points by number (K,), or of a slice."""
        numbers = self._numbers(which)
        return self._local(self._unpack(numbers, self._packed.words, 0))

    def span(self, first: int, stop: int) -> tuple[int, int]:
        """Return the begin and end of the words of points ``first`` to before ``stop``."""
        if first >= stop:
            return 0, 0
        blocks = np.searchsorted(self._first, [first, stop - 1], side="right") - 1
        return int(self._word[blocks[0]]), int(self._word[blocks[1] + 1])

    def local(self, first: int, stop: int, words: NDArray[np.uint64]) -> NDArray[np.float32]:
        """Local coordinates of a run of points, from the words of their span."""
        return self._local(self.source(first, stop, words))

    def source(self, first: int, stop: int, words: NDArray[np.uint64]) -> NDArray[Any]:
        """Coordinates of the same as they were imported, bit for bit."""
        return self._unpack(np.arange(first, stop), words, self.span(first, stop)[0])

    def _numbers(self, which: Which) -> NDArray[np.int64]:
        if isinstance(which, slice):
            return np.arange(*which.indices(len(self)))
        if which.dtype == np.bool_:
            return np.flatnonzero(which)
        numbers = np.ascontiguousarray(which, np.int64)
        if len(numbers) and not 0 <= int(numbers.min()) <= int(numbers.max()) < len(self):
            raise IndexError(f"expected points 0 to {len(self) - 1}, got others")
        return numbers

    def _unpack(
        self, numbers: NDArray[np.int64], words: NDArray[np.uint64], first_word: int
    ) -> NDArray[Any]:
        # Loaded with the first request for points of an octree.
        from pointbrush.sequences.octree.loops import Blocks, unpack

        out = np.empty((len(numbers), 3), self._dtype)
        packed, word = self._packed, self._word - first_word if first_word else self._word
        blocks = Blocks(word, self._first, packed.base, packed.bits, self._scaling)
        unpack(words, blocks, numbers, out, _patterns(out))
        return out

    def _local(self, source: NDArray[Any]) -> NDArray[np.float32]:
        if source.dtype == np.float32 and not self._shift.any():
            return source
        from pointbrush.sequences.octree.loops import shifted

        local = np.empty(source.shape, np.float32)
        shifted(source, self._shift, local)
        return local
