"""Whole annotations in source order on their way into the store, as one edit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, LockedLabelError
from pointbrush.labels import LabelStore, Write
from pointbrush.sequences import Sequence as Recording

LAYERS: dict[str, type] = {"label": np.uint16, "provenance": np.uint8, "deleted": np.bool_}
IMPORTED = 3
PIECE_POINTS = 1_000_000


def require_layer(layer: str) -> np.dtype[Any]:
    """The layer's type; raises BadInputError for an unknown one."""
    if layer not in LAYERS:
        raise BadInputError(f"layer: expected one of {', '.join(LAYERS)}, got {layer!r}")
    return np.dtype(LAYERS[layer])


def replacement(
    store: LabelStore, recording: Recording, frame: int, layer: str, array: NDArray[Any]
) -> Write:
    """The write that makes a frame's layer equal ``array`` (N,), source order.

    Raises BadInputError (shape, type, unknown labels, values), LockedLabelError.
    """
    dtype, stored, sequence = require_layer(layer), recording[frame], recording.manifest.id
    if array.shape != (stored.count,) or array.dtype != dtype:
        raise BadInputError(
            f"annotation: expected ({stored.count},) {dtype}, got {array.shape} {array.dtype}"
        )
    found = [
        _difference(store, recording, frame, layer, array, first)
        for first in range(0, max(stored.count, 1), PIECE_POINTS)
    ]
    numbers, before, value = (np.concatenate(parts) for parts in zip(*found, strict=True))
    if layer == "label":
        _require_allowed(store, sequence, before, value)
        provenance = np.where(value > 0, IMPORTED, 0).astype(np.uint8)
        return Write(numbers, label=value, provenance=provenance)
    if layer == "provenance":
        if value.size and value.max() > IMPORTED:
            raise BadInputError(f"provenance: expected 0 to 3, got {int(value.max())}")
        return Write(numbers, provenance=value)
    return Write(numbers, deleted=value)


def _difference(
    store: LabelStore,
    recording: Recording,
    frame: int,
    layer: str,
    array: NDArray[Any],
    first: int,
) -> tuple[NDArray[np.int64], NDArray[Any], NDArray[Any]]:
    """Where a piece from stored number ``first`` on is not as wanted: numbers, values, wanted."""
    stored = recording[frame]
    stop = min(first + PIECE_POINTS, stored.count)
    wanted = array[stored.read("source_index", first, stop)]
    values = store.values(recording.manifest.id, frame, first, stop - first)
    now = getattr(values, layer)
    differs = np.flatnonzero(wanted != now)
    return differs + first, now[differs], wanted[differs]


def _require_allowed(
    store: LabelStore, sequence: str, now: NDArray[np.uint16], wanted: NDArray[np.uint16]
) -> None:
    palette = {label.id: label for label in store.palette(sequence)}
    unknown = [n for n in np.unique(wanted).tolist() if n and n not in palette]
    if unknown:
        raise BadInputError(
            f"annotation: expected labels of the palette, got unknown {unknown[:10]}"
        )
    locked = [label.id for label in palette.values() if label.locked]
    if (np.isin(now, locked) | np.isin(wanted, locked)).any():
        raise LockedLabelError("annotation: expected no change of points of locked labels")
