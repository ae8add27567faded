"""Prepared state of a frame, by which a click is answered at once."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.exchange.npz import Arrays, checked, read_npz
from pointbrush.selection.objects.sums import PAIR_WIDTH, WIDTH, Pieces
from pointbrush.selection.objects.tree import MergeTree
from pointbrush.sensor_kind import SENSOR_KINDS, SensorKind

VERSION = 7
"""Of the file; a state of another version is prepared anew."""
MOST_BYTES = 16 * 2**30
"""Of the file, unpacked: some 400 bytes a cell, and a cell holds a point or more."""
FINITE = (-1e30, 1e30)
"""Bounds of coordinates, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class ObjectFrame:
    """Points of one frame as selection sees them: stored order, local coordinates, metres.

    ``xyz`` (N, 3); ``rgb`` (N, 3) uint8 or None; ``intensity`` (N,) or None; ``viewpoint`` (3,)
    of the sensor or None; ``T_room_local`` (4, 4) stands it on its floor, y up.
    """

    xyz: NDArray[np.floating]
    rgb: NDArray[np.uint8] | None = None
    intensity: NDArray[np.floating] | None = None
    viewpoint: NDArray[np.float64] | None = None
    sensor: SensorKind = "room"
    T_room_local: NDArray[np.float64] | None = None

    def check(self) -> None:
        """Raise BadInputError for arrays of the wrong shape and unknown sensors."""
        if self.xyz.ndim != 2 or self.xyz.shape[1] != 3:
            raise BadInputError(f"xyz: expected (N, 3), got {self.xyz.shape}")
        for name, column, shape in (
            ("rgb", self.rgb, self.xyz.shape),
            ("intensity", self.intensity, self.xyz.shape[:1]),
            ("viewpoint", self.viewpoint, (3,)),
            ("T_room_local", self.T_room_local, (4, 4)),
        ):
            if column is not None and column.shape != shape:
                raise BadInputError(f"{name}: expected {shape}, got {column.shape}")
        if self.sensor not in SENSOR_KINDS:
            raise BadInputError(
                f"sensor: expected one of {', '.join(SENSOR_KINDS)}, got {self.sensor!r}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class ObjectState:
    """Cells, pieces and merge tree of a frame; its arrays cannot be written to.

    ``sensor`` and ``size`` of the cells, metres;
    ``of_point`` (N,) int32 cell of each point, -1 for one without finite coordinates;
    ``center`` (C, 3) float32 local metres; ``piece`` (C,) int32 piece of each cell;
    ``pairs`` (B, 2) neighbouring pieces, ``between`` (B, 6) sums of their boundaries;
    ``viewpoint`` (3,) of the sensor, local metres, the origin where it is unknown;
    ``plane`` (n, P) plane that a piece lies on, -1 for none, by each of n partitions.
    """

    sensor: SensorKind
    size: float
    of_point: NDArray[np.int32]
    center: NDArray[np.float32]
    piece: NDArray[np.int32]
    pairs: NDArray[np.int32]
    between: NDArray[np.float32]
    parent: NDArray[np.int32]
    score: NDArray[np.float32]
    sums: NDArray[np.float64]
    first: NDArray[np.float32]
    viewpoint: NDArray[np.float64]
    plane: NDArray[np.int32]

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def piece_count(self) -> int:
        """Number of pieces; the tree's further nodes come after them."""
        return len(self.sums) - int(np.isfinite(self.score).sum())

    def save(self, path: Path) -> None:
        """Write to a file (.npz)."""
        arrays: dict[str, Any] = {each.name: getattr(self, each.name) for each in fields(self)}
        with path.open("wb") as file:
            np.savez(file, version=np.array(VERSION), **arrays)

    @classmethod
    def load(cls, path: Path) -> ObjectState:
        """Read a file that ``save`` wrote.

        Raises BadInputError for one of another version and for anything else.
        """
        try:
            return _state(read_npz(path, MOST_BYTES))
        except (OSError, BadInputError, ValueError, TypeError) as error:
            raise BadInputError(f"{path.name}: expected a saved object state: {error}") from None


def _state(arrays: Arrays) -> ObjectState:
    """Check the arrays of a state: the loops that read them index without checks."""
    version = int(checked(arrays, "version", np.int64, ()))
    if version != VERSION:
        raise BadInputError(f"expected version {VERSION}, got {version}")
    sensor, size = str(arrays.get("sensor")), float(checked(arrays, "size", np.float64, ()))
    if sensor not in SENSOR_KINDS:
        raise BadInputError(f"expected a known sensor, got {sensor!r}")
    score = checked(arrays, "score", np.float32, (None,))
    nodes = len(score)
    pieces = nodes - int(np.isfinite(score).sum())
    center = checked(arrays, "center", np.float32, (None, 3), *FINITE)
    pairs = checked(arrays, "pairs", np.int32, (None, 2), 0, pieces - 1)
    parent = checked(arrays, "parent", np.int32, (nodes,), -1, nodes - 1)
    inner = parent >= 0
    if not (np.isposinf(score[:pieces]).all() and (parent > np.arange(nodes))[inner].all()):
        raise BadInputError("expected pieces, then nodes with later parents, got another order")
    return ObjectState(
        sensor, size,
        checked(arrays, "of_point", np.int32, (None,), -1, len(center) - 1),
        center,
        checked(arrays, "piece", np.int32, (len(center),), 0, pieces - 1),
        pairs,
        checked(arrays, "between", np.float32, (len(pairs), PAIR_WIDTH)),
        parent,
        score,
        checked(arrays, "sums", np.float64, (nodes, WIDTH)),
        checked(arrays, "first", np.float32, (len(pairs),)),
        checked(arrays, "viewpoint", np.float64, (3,), *FINITE),
        checked(arrays, "plane", np.int32, (None, pieces)),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """A frame up to the merge tree: what training and ``prepare`` share.

    ``of_point`` (N,) int32 cell of each point, -1 for none; ``center`` (C, 3) and ``viewpoint``
    (3,) local, metres; ``plane`` (n, P) of each piece, -1 for none.
    """

    of_point: NDArray[np.int32]
    center: NDArray[np.float64]
    size: float
    piece: NDArray[np.int64]
    pieces: Pieces
    viewpoint: NDArray[np.float64]
    plane: NDArray[np.int64]


def state_of(parts: Parts, sensor: SensorKind, tree: MergeTree) -> ObjectState:
    """Return the state in the types that it is kept in."""
    return ObjectState(
        sensor,
        parts.size,
        parts.of_point,
        parts.center.astype(np.float32),
        parts.piece.astype(np.int32),
        parts.pieces.pairs.astype(np.int32),
        parts.pieces.between.astype(np.float32),
        tree.parent.astype(np.int32),
        tree.score.astype(np.float32),
        tree.sums,
        tree.first.astype(np.float32),
        parts.viewpoint,
        parts.plane.astype(np.int32),
    )
