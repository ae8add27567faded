"""Check a Write and split it into blocks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import (
    BadInputError,
    HiddenLabelError,
    LockedLabelError,
    NotFoundError,
)
from pointbrush.labels.classes.palette import HIGHEST
from pointbrush.labels.packing import BLOCK, PROVENANCE_SHIFT, confidence_bits
from pointbrush.labels.types import PREDICTED, Label, Only, Write
from pointbrush.ranges import by_block

RULES = get_args(Only)


@dataclass(frozen=True, slots=True, eq=False)
class BlockWrite:
    """A Write within one block: (n,) point numbers in it and (n,) uint64 values, or None."""

    block: int
    indices: NDArray[np.int64]
    label: NDArray[np.uint64] | None
    came: NDArray[np.uint64] | None
    """Bits of provenance and confidence."""
    deleted: NDArray[np.uint64] | None
    only: str
    living: bool | None


def cut(write: Write, points: int, palette: dict[int, Label]) -> Iterator[BlockWrite]:
    """Yield the parts of ``write`` on a frame of ``points`` points, block by block.

    Raises BadInputError, NotFoundError (label), LockedLabelError or HiddenLabelError (a single
    label that is locked, or hidden while ``hidden`` is given).
    """
    indices = _indices(write.indices, points)
    label = _values("label", write.label, len(indices), HIGHEST)
    provenance = _values("provenance", write.provenance, len(indices), PREDICTED)
    confidence = _values("confidence", write.confidence, len(indices), 255)
    deleted = _values("deleted", write.deleted, len(indices), 1)
    if write.only not in RULES:
        raise BadInputError(f"only: expected one of {', '.join(RULES)}, got {write.only!r}")
    _require_labels(write, label, palette)
    for first, span in by_block(indices, BLOCK):
        yield BlockWrite(
            first // BLOCK,
            indices[span] - first,
            None if label is None else label[span],
            None if provenance is None else _came(provenance, confidence, span),
            None if deleted is None else deleted[span],
            write.only,
            write.living,
        )


def _came(
    provenance: NDArray[np.uint64], confidence: NDArray[np.uint64] | None, span: slice
) -> NDArray[np.uint64]:
    """Return the bits of provenance and confidence of some points."""
    bits = provenance[span] << PROVENANCE_SHIFT
    return bits if confidence is None else bits | confidence_bits(confidence[span])


def _indices(given: Any, points: int) -> NDArray[np.int64]:
    indices = np.asarray(given)
    if indices.size == 0:
        return np.empty(0, np.int64)
    if indices.ndim != 1 or indices.dtype.kind not in "iu":
        raise BadInputError(f"indices: expected (n,) integers, got {indices.shape} {indices.dtype}")
    indices = indices.astype(np.int64)
    if (indices[1:] <= indices[:-1]).any():
        raise BadInputError("indices: expected strictly increasing point numbers")
    if indices[0] < 0 or indices[-1] >= points:
        raise BadInputError(
            f"indices: expected point numbers 0 to {points - 1}, got {indices[0]} to {indices[-1]}"
        )
    return indices


def _values(name: str, given: Any, n: int, highest: int) -> NDArray[np.uint64] | None:
    if given is None:
        return None
    values = np.asarray(given)
    if values.dtype.kind not in "iub" or values.shape not in ((), (n,)):
        raise BadInputError(
            f"{name}: expected an integer or ({n},) integers, got {values.shape} {values.dtype}"
        )
    if values.size and (int(values.min()) < 0 or int(values.max()) > highest):
        raise BadInputError(
            f"{name}: expected 0 to {highest}, got {int(values.min())} to {int(values.max())}"
        )
    return np.broadcast_to(values.astype(np.uint64), (n,))


def _require_labels(
    write: Write, label: NDArray[np.uint64] | None, palette: dict[int, Label]
) -> None:
    if label is None:
        return
    if np.ndim(write.label) == 0:  # type: ignore[arg-type]  # not None here
        number = int(write.label)  # type: ignore[arg-type]  # a checked scalar
        require_paintable(palette, number, write.hidden)
        return
    for used in np.unique(label).tolist():
        if used and used not in palette:
            raise NotFoundError(f"label: expected labels of the palette, got {used}")


def require_paintable(
    palette: dict[int, Label], label: int, hidden: frozenset[int] | None = None
) -> None:
    """Raise NotFoundError, LockedLabelError or HiddenLabelError unless a label can be painted.

    ``hidden``: as of a Write.
    """
    if label == 0:
        return
    if label not in palette:
        raise NotFoundError(f"label: expected a label of the palette, got {label}")
    if palette[label].locked:
        raise locked_error(palette, label)
    if hidden is not None and (label in hidden or not palette[label].visible):
        name = palette[label].name
        raise HiddenLabelError(f"label: '{name}' ({label}) is hidden; show it to paint with it")


def locked_error(palette: dict[int, Label], label: int) -> LockedLabelError:
    """Return the error for a locked label."""
    return LockedLabelError(f"label: '{palette[label].name}' ({label}) is locked; unlock it first")
