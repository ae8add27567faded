"""Whole annotations of a frame: read at one revision, and replaced as one edit."""

from __future__ import annotations

import zlib
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, LockedLabelError
from pointbrush.labels import Label, LabelStore, Write
from pointbrush.labels.packing import BLOCK
from pointbrush.labels.types import FULL_CONFIDENCE, IMPORTED, PREDICTED
from pointbrush.labels.versions import PastLabels
from pointbrush.sequences import Sequence as Recording

_LEVEL = 1  # zlib: the fastest; neighbours in stored order mostly have the same label
LAYERS: dict[str, type] = {
    "label": np.uint16,
    "provenance": np.uint8,
    "deleted": np.bool_,
    "confidence": np.uint8,
}
PIECE_POINTS = 16 * BLOCK
"""Number of points compared at once: whole blocks of the journal."""
READ_POINTS = 1_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Packed:
    """Values of a run of points: compressed, or a single value if all are equal."""

    count: int
    dtype: np.dtype[Any]
    data: bytes | None
    value: Any

    @classmethod
    def of(cls, values: NDArray[Any]) -> Packed:
        """Pack values (N,)."""
        same = not len(values) or bool((values == values[0]).all())
        data = None if same else zlib.compress(values.tobytes(), _LEVEL)
        return cls(len(values), values.dtype, data, values[0] if same and len(values) else 0)

    def values(self) -> NDArray[Any]:
        """Return the values (N,)."""
        if self.data is None:
            return np.full(self.count, self.value, self.dtype)
        return np.frombuffer(zlib.decompress(self.data), self.dtype)


def require_layer(layer: str) -> np.dtype[Any]:
    """Return the type of a layer; raises BadInputError for an unknown layer."""
    if layer not in LAYERS:
        raise BadInputError(f"layer: expected one of {', '.join(LAYERS)}, got {layer!r}")
    return np.dtype(LAYERS[layer])


def replacement(
    store: LabelStore, recording: Recording, frame: int, layer: str, array: NDArray[Any]
) -> Iterator[tuple[int, Write]]:
    """Return the writes that make a frame's layer equal to ``array`` (N,), source order.

    The differences are computed at once and compressed, so that a whole scan needs little memory.
    Raises BadInputError (shape, type, unknown labels, values), LockedLabelError.
    """
    dtype, stored = require_layer(layer), recording[frame]
    if array.shape != (stored.count,) or array.dtype != dtype:
        raise BadInputError(
            f"annotation: expected ({stored.count},) {dtype}, got {array.shape} {array.dtype}"
        )
    if layer == "confidence":
        raise BadInputError("layer: expected one that can be written, confidence is predicted")
    if layer == "provenance" and array.size and array.max() > PREDICTED:
        raise BadInputError(f"provenance: expected 0 to {PREDICTED}, got {int(array.max())}")
    palette = {label.id: label for label in store.palette(recording.manifest.id)}
    found = [
        _difference(store, recording, frame, layer, array, first, palette)
        for first in range(0, stored.count, PIECE_POINTS)
    ]
    return ((frame, piece.write(layer)) for piece in found if piece.wanted.count)


@dataclass(frozen=True, slots=True, eq=False)
class _Difference:
    """The points of a piece from stored number ``first`` that change, and their values."""

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


class KeptAnnotation:
    """A frame's layers in stored order, compressed; ``revision``: of its last change."""

    def __init__(
        self,
        store: LabelStore | PastLabels,
        sequence: str,
        frame: int,
        layers: Collection[str] = tuple(LAYERS),
        above: float = 0.0,
    ) -> None:
        """Read ``layers`` piece by piece; commits wait meanwhile.

        ``above``: predicted points with a lower confidence, 0 to 1, count as unlabeled.
        """
        self.revision = 0
        self.sizes = np.zeros(1, np.int64)
        """Number of points of each label that are not deleted, by label id."""
        self._pieces: list[dict[str, Packed]] = []
        for values in store.runs(sequence, frame, READ_POINTS):
            self.revision = values.changed
            if above > 0:
                below = values.confidence < above * FULL_CONFIDENCE
                unsure = (values.provenance == PREDICTED) & below
                values.label[unsure] = values.provenance[unsure] = 0
            self._pieces.append({name: Packed.of(getattr(values, name)) for name in layers})
            counts = np.bincount(values.label[~values.deleted], minlength=len(self.sizes))
            counts[: len(self.sizes)] += self.sizes
            self.sizes = counts.astype(np.int64)

    def read(self, first: int, stop: int) -> dict[str, NDArray[Any]]:
        """Return the layers of points ``first`` to ``stop`` - 1."""
        found: dict[str, list[NDArray[Any]]] = {name: [] for name in self._pieces[0]}
        begin, end = first // READ_POINTS, max(first, stop - 1) // READ_POINTS
        for number in range(begin, min(end + 1, len(self._pieces))):
            start = number * READ_POINTS
            for name, packed in self._pieces[number].items():
                found[name].append(packed.values()[max(first - start, 0) : max(stop - start, 0)])
        return {
            name: parts[0] if len(parts) == 1 else np.concatenate(parts)
            for name, parts in found.items()
        }
