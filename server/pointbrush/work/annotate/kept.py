"""A frame's annotation as it was at one revision, however long it is read from."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.labels import LabelStore
from pointbrush.work.annotate.layers import LAYERS
from pointbrush.work.annotate.packed import Packed

PIECE_POINTS = 1_000_000


class KeptAnnotation:
    """A frame's layers in stored order, compressed; ``revision`` is that of its last change."""

    def __init__(
        self, store: LabelStore, sequence: str, frame: int, layers: Collection[str] = tuple(LAYERS)
    ) -> None:
        """Read ``layers`` piece by piece; nothing is committed meanwhile."""
        self.revision = 0
        self.sizes = np.zeros(1, np.int64)
        """Points of each label that are not deleted, by label id."""
        self._pieces: list[dict[str, Packed]] = []
        for values in store.runs(sequence, frame, PIECE_POINTS):
            self.revision = values.changed
            self._pieces.append({name: Packed.of(getattr(values, name)) for name in layers})
            counts = np.bincount(values.label[~values.deleted], minlength=len(self.sizes))
            counts[: len(self.sizes)] += self.sizes
            self.sizes = counts.astype(np.int64)

    def read(self, first: int, stop: int) -> dict[str, NDArray[Any]]:
        """The layers of points ``first`` to before ``stop``."""
        found: dict[str, list[NDArray[Any]]] = {name: [] for name in self._pieces[0]}
        begin, end = first // PIECE_POINTS, max(first, stop - 1) // PIECE_POINTS
        for number in range(begin, min(end + 1, len(self._pieces))):
            start = number * PIECE_POINTS
            for name, packed in self._pieces[number].items():
                found[name].append(packed.values()[max(first - start, 0) : max(stop - start, 0)])
        return {
            name: parts[0] if len(parts) == 1 else np.concatenate(parts)
            for name, parts in found.items()
        }
