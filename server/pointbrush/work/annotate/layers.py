"""Whole annotations in source order on their way into the store, as one edit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, LockedLabelError
from pointbrush.labels import Label, LabelStore, Write
from pointbrush.labels.packing import BLOCK
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.packed import Packed

LAYERS: dict[str, type] = {"label": np.uint16, "provenance": np.uint8, "deleted": np.bool_}
IMPORTED = 3
PIECE_POINTS = 16 * BLOCK
"""Points compared at once: whole blocks of the journal."""


def require_layer(layer: str) -> np.dtype[Any]:
    """The layer's type; raises BadInputError for an unknown one."""
    if layer not in LAYERS:
        raise BadInputError(f"layer: expected one of {', '.join(LAYERS)}, got {layer!r}")
    return np.dtype(LAYERS[layer])


def replacement(
    store: LabelStore, recording: Recording, frame: int, layer: str, array: NDArray[Any]
) -> Iterator[tuple[int, Write]]:
    """The writes that make a frame's layer equal ``array`` (N,), source order.

    What differs is found at once and kept compressed, so that a whole scan takes little memory.
    Raises BadInputError (shape, type, unknown labels, values), LockedLabelError.
    """
    dtype, stored = require_layer(layer), recording[frame]
    if array.shape != (stored.count,) or array.dtype != dtype:
        raise BadInputError(
            f"annotation: expected ({stored.count},) {dtype}, got {array.shape} {array.dtype}"
        )
    if layer == "provenance" and array.size and array.max() > IMPORTED:
        raise BadInputError(f"provenance: expected 0 to 3, got {int(array.max())}")
    palette = {label.id: label for label in store.palette(recording.manifest.id)}
    found = [
        _difference(store, recording, frame, layer, array, first, palette)
        for first in range(0, stored.count, PIECE_POINTS)
    ]
    return ((frame, piece.write(layer)) for piece in found if piece.wanted.count)


@dataclass(frozen=True, slots=True, eq=False)
class _Difference:
    """Return the points of a piece from stored number ``first`` that change, and their values."""

    first: int
    differs: Packed
    wanted: Packed

    def write(self, layer: str) -> Write:
        numbers, value = np.flatnonzero(self.differs.values()) + self.first, self.wanted.values()
        if layer == "label":
            provenance = np.where(value > 0, IMPORTED, 0).astype(np.uint8)
            return Write(numbers, label=value, provenance=provenance)
        if layer == "provenance":
            return Write(numbers, provenance=value)
        return Write(numbers, deleted=value)


def _difference(
    store: LabelStore,
    recording: Recording,
    frame: int,
    layer: str,
    array: NDArray[Any],
    first: int,
    palette: dict[int, Label],
) -> _Difference:
    stored = recording[frame]
    stop = min(first + PIECE_POINTS, stored.count)
    wanted = array[stored.read("source_index", first, stop)]
    now = getattr(store.values(recording.manifest.id, frame, first, stop - first), layer)
    differs = wanted != now
    if layer == "label":
        _require_allowed(palette, now[differs], wanted[differs])
    return _Difference(first, Packed.of(differs), Packed.of(wanted[differs]))


def _require_allowed(
    palette: dict[int, Label], now: NDArray[np.uint16], wanted: NDArray[np.uint16]
) -> None:
    unknown = [n for n in np.unique(wanted).tolist() if n and n not in palette]
    if unknown:
        raise BadInputError(
            f"annotation: expected labels of the palette, got unknown {unknown[:10]}"
        )
    locked = [label.id for label in palette.values() if label.locked]
    if (np.isin(now, locked) | np.isin(wanted, locked)).any():
        raise LockedLabelError("annotation: expected no change of points of locked labels")
