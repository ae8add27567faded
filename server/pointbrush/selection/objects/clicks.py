"""Clicks on a prepared frame: the cells and pieces they lie on, and how far all others are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.errors import BadInputError
from pointbrush.selection.objects.state import ObjectState

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Clicks:
    """K clicks: ``at`` (K, 3) local metres, ``cell`` and ``piece`` (K,) that each lies on.

    ``nearest``, ``farthest`` (K, P): distances from a click to the cells of each piece, metres.
    """

    at: Floats
    cell: Ints
    piece: Ints
    nearest: Floats
    farthest: Floats

    def __len__(self) -> int:
        return len(self.at)


def place_clicks(state: ObjectState, at: NDArray[np.floating], name: str) -> Clicks:
    """Return where clicks (K, 3) lie.  Raises BadInputError unless they are finite and 3 wide."""
    if np.size(at) and (np.ndim(at) != 2 or np.shape(at)[1] != 3):
        raise BadInputError(f"{name}: expected (K, 3) local coordinates, got {np.shape(at)}")
    points = np.asarray(at, np.float64).reshape(-1, 3)
    if not np.isfinite(points).all():
        raise BadInputError(f"{name}: expected finite coordinates")
    if len(state.center) == 0:
        points = points[:0]
    cell, nearest, farthest = _distances(state.center, state.piece, points, state.piece_count)
    return Clicks(points, cell, state.piece[cell].astype(np.int64), nearest, farthest)


@compiled
def _distances(
    center: NDArray[np.float32], piece: NDArray[np.int32], at: Floats, pieces: int
) -> tuple[Ints, Floats, Floats]:
    nearest = np.full((len(at), pieces), np.inf)
    farthest = np.zeros((len(at), pieces))
    own = np.zeros(len(at), np.int64)
    for k in range(len(at)):
        least = np.inf
        x, y, z = at[k, 0], at[k, 1], at[k, 2]
        for c in range(len(center)):
            away = (center[c, 0] - x) ** 2 + (center[c, 1] - y) ** 2 + (center[c, 2] - z) ** 2
            p = piece[c]
            nearest[k, p] = min(nearest[k, p], away)
            farthest[k, p] = max(farthest[k, p], away)
            if away < least:
                least = away
                own[k] = c
    return own, np.sqrt(nearest), np.sqrt(farthest)


def kept_cells(state: ObjectState, wanted: Clicks, unwanted: Clicks) -> NDArray[np.bool_]:
    """Return the cells (C,) that may be added; of pieces clicked both ways the nearer ones."""
    shared = np.zeros(state.piece_count, np.bool_)
    shared[np.intersect1d(wanted.piece, unwanted.piece)] = True
    cells = np.flatnonzero(shared[state.piece])
    kept = np.ones(len(state.center), np.bool_)
    if len(cells):
        kept[cells] = _away(state.center[cells], wanted.at) <= _away(
            state.center[cells], unwanted.at
        )
        kept[wanted.cell] = True
        kept[unwanted.cell] = False
    return kept


def _away(cells: NDArray[np.float32], clicks: Floats) -> Floats:
    """Distance (n,) of cells from the nearest click."""
    return np.asarray(np.linalg.norm(cells[:, None] - clicks, axis=2).min(axis=1))
