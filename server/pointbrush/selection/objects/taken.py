"""Points taken so far, and the least that a click changes of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.objects.clicks import Clicks
from pointbrush.selection.objects.options import PatchOptions
from pointbrush.selection.objects.state import ObjectState

Mask = NDArray[np.bool_]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """``cells`` (C,) taken so far, with a patch round each click that they were wrong about.

    ``pieces`` (P,) of which most cells were taken before; ``missed`` pieces of wanted clicks that
    lay outside, ``surplus`` of unwanted ones that lay inside.
    """

    cells: Mask
    pieces: Mask
    missed: Ints
    surplus: Ints


def taken_so_far(
    state: ObjectState,
    mask: NDArray[np.integer] | Mask | None,
    wanted: Clicks,
    unwanted: Clicks,
    options: PatchOptions,
) -> Taken | None:
    """Return what a mask over points (numbers, or (N,) bool) holds, None for an empty one.

    Raises BadInputError for a mask out of range.
    """
    if mask is None:
        return None
    points = state.of_point[_chosen(mask, len(state.of_point))]
    every = state.of_point[state.of_point >= 0]
    held = np.bincount(points[points >= 0], minlength=len(state.center))
    cells = 2 * held > np.bincount(every, minlength=len(state.center))
    if not cells.any():
        return None
    of_piece = np.bincount(state.piece, minlength=state.piece_count)
    pieces = 2 * np.bincount(state.piece[cells], minlength=state.piece_count) > of_piece
    missed, surplus = ~cells[wanted.cell], cells[unwanted.cell]
    patched = cells.copy()
    for at, piece in zip(wanted.at[missed], wanted.piece[missed], strict=True):
        patched[_patch(state, at, int(piece), cells, options)] = True
    for at, piece in zip(unwanted.at[surplus], unwanted.piece[surplus], strict=True):
        patched[_patch(state, at, int(piece), ~cells, options)] = False
    patched[wanted.cell] = True
    patched[unwanted.cell] = False
    return Taken(patched, pieces, wanted.piece[missed], unwanted.piece[surplus])


def _chosen(mask: NDArray[np.integer] | Mask, count: int) -> NDArray[np.integer] | Mask:
    if mask.dtype == np.bool_:
        if mask.shape != (count,):
            raise BadInputError(f"mask: expected ({count},), got {mask.shape}")
    elif len(mask) and not 0 <= mask.min() <= mask.max() < count:
        raise BadInputError(f"mask: expected point numbers 0 to {count - 1}")
    return mask if len(mask) else np.empty(0, np.int64)


def _patch(
    state: ObjectState, at: NDArray[np.float64], piece: int, border: Mask, options: PatchOptions
) -> Ints:
    """Cells of a piece that are nearer to a click than ``border`` (C,) is; all, if most are."""
    own = np.flatnonzero(state.piece == piece)
    away = np.linalg.norm(state.center[own] - at, axis=1)
    beyond = state.center[border]
    radius = float(np.linalg.norm(beyond - at, axis=1).min()) if len(beyond) else np.inf
    near = own[away <= max(radius, options.least_cells * state.size)]
    return own if len(near) >= options.whole_share * len(own) else near
