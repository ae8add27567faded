"""Clicks on a prepared frame: their cells and pieces, distances, and corrections.

The module computes distances of cells from clicks, the points taken so far, and the minimal
correction of these by a click.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.errors import BadInputError
from pointbrush.selection.objects import sums
from pointbrush.selection.objects.options import ClickOptions
from pointbrush.selection.objects.state import ObjectState

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Clicks:
    """K clicks: ``at`` (K, 3) in local metres, with the ``cell`` and ``piece`` (K,) of each.

    ``nearest``, ``farthest`` (K, P): distances of a click from the cells of each piece, metres.
    """

    at: Floats
    cell: Ints
    piece: Ints
    nearest: Floats
    farthest: Floats

    def __len__(self) -> int:
        return len(self.at)


def place_clicks(
    state: ObjectState,
    at: NDArray[np.floating],
    name: str,
    options: ClickOptions | None = None,
    first: bool = True,
) -> Clicks:
    """Return clicks (K, 3) on the nearest cells, except isolated ones if a piece is within reach.

    With ``first``, so while nothing is taken, a click on an isolated lidar return moves to the
    nearest piece in about the same direction; later ones correct exactly where they are.
    Raises BadInputError unless they are finite and 3 wide.
    """
    options = options or ClickOptions()
    if np.size(at) and (np.ndim(at) != 2 or np.shape(at)[1] != 3):
        raise BadInputError(f"{name}: expected (K, 3) local coordinates, got {np.shape(at)}")
    points = np.array(at, np.float64).reshape(-1, 3)
    if not np.isfinite(points).all():
        raise BadInputError(f"{name}: expected finite coordinates")
    if len(state.center) == 0:
        points = points[:0]
    real = state.sums[: state.piece_count, sums.COUNT] >= options.real_cells
    reach = options.real_reach * state.size
    cell, nearest, farthest = _distances(state.center, state.piece, points, real, reach)
    if first and state.sensor == "lidar":
        beside = [
            _nearest_cell_along(state, *each, real, options)
            for each in zip(points, cell, strict=True)
        ]
        moved = np.array(beside, np.int64) != cell
        if moved.any():
            points[moved] = state.center[beside][moved]
            cell, nearest, farthest = _distances(state.center, state.piece, points, real, reach)
    return Clicks(points, cell, state.piece[cell].astype(np.int64), nearest, farthest)


def _nearest_cell_along(
    state: ObjectState, at: Floats, cell: int, real: Mask, options: ClickOptions
) -> int:
    """Return the nearest cell of a piece in about the direction of a click.

    ``at`` (3,): position of the click; ``cell``: its cell, returned if there is no other.
    """
    if state.sums[state.piece[cell], sums.COUNT] >= options.lone_cells:
        return cell
    ways, way = state.center - state.viewpoint, at - state.viewpoint
    least = np.cos(np.radians(options.lone_angle)) * np.linalg.norm(way)
    near = np.flatnonzero(real[state.piece] & (ways @ way >= least * np.linalg.norm(ways, axis=1)))
    if len(near) == 0:
        return cell
    return int(near[np.linalg.norm(state.center[near] - at, axis=1).argmin()])


@compiled
def _distances(
    center: NDArray[np.float32], piece: NDArray[np.int32], at: Floats, real: Mask, reach: float
) -> tuple[Ints, Floats, Floats]:
    pieces = len(real)
    nearest = np.full((len(at), pieces), np.inf)
    farthest = np.zeros((len(at), pieces))
    own = np.zeros(len(at), np.int64)
    for k in range(len(at)):
        least = least_real = np.inf
        own_real = 0
        x, y, z = at[k, 0], at[k, 1], at[k, 2]
        for c in range(len(center)):
            square = (center[c, 0] - x) ** 2 + (center[c, 1] - y) ** 2 + (center[c, 2] - z) ** 2
            p = piece[c]
            nearest[k, p] = min(nearest[k, p], square)
            farthest[k, p] = max(farthest[k, p], square)
            if square < least:
                least = square
                own[k] = c
            if real[p] and square < least_real:
                least_real = square
                own_real = c
        if np.sqrt(least_real) <= np.sqrt(least) + reach:
            own[k] = own_real
    return own, np.sqrt(nearest), np.sqrt(farthest)


def kept_cells(state: ObjectState, wanted: Clicks, unwanted: Clicks) -> NDArray[np.bool_]:
    """Return a mask of cells (C,) that may be added.

    In pieces with wanted and unwanted clicks, these are the cells nearer to wanted ones.
    """
    kept = np.ones(len(state.center), np.bool_)
    both = np.intersect1d(wanted.piece, unwanted.piece)
    if len(both):
        cells = np.flatnonzero(np.isin(state.piece, both))
        kept[cells] = _nearest_distance(state.center[cells], wanted.at) <= _nearest_distance(
            state.center[cells], unwanted.at
        )
        kept[wanted.cell] = True
        kept[unwanted.cell] = False
    return kept


def _nearest_distance(cells: NDArray[np.float32], clicks: Floats) -> Floats:
    """Return distances (n,) of cells from the nearest click."""
    return np.asarray(np.linalg.norm(cells[:, None] - clicks, axis=2).min(axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """``cells`` (C,): mask of cells taken so far, corrected around contradicting clicks.

    ``least`` (C,): the same with small corrections, for lidar selections that are likely right;
    ``far``: distance of the farthest contradicting click from their border, metres;
    ``pieces`` (P,): mask of pieces with most cells taken before; ``missed``: pieces of wanted
    clicks outside; ``surplus``: pieces of unwanted clicks inside.
    """

    cells: Mask
    least: Mask
    far: float
    pieces: Mask
    missed: Ints
    surplus: Ints


def taken_so_far(
    state: ObjectState,
    mask: NDArray[np.integer] | Mask | None,
    wanted: Clicks,
    unwanted: Clicks,
    options: ClickOptions,
) -> Taken | None:
    """Return the taken cells of a mask over points (numbers, or (N,) bool); None: it is empty.

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
    most = max(int(options.sure_patch * np.count_nonzero(cells)), 1)
    clearances = [_clearance(state, at, cells) for at in wanted.at[missed]]
    clearances += [_clearance(state, at, ~cells) for at in unwanted.at[surplus]]

    def reach(at: Floats, border: Mask, share: float) -> float:
        return max(share * _clearance(state, at, border), options.least_cells * state.size)

    def corrected(most: int, share: float) -> Mask:
        patched = cells.copy()
        for at, p in zip(wanted.at[missed], wanted.piece[missed], strict=True):
            near = reach(at, cells, share)
            patched[_patch(state, at, int(p), most, near, options.whole_share)] = True
        for at, p in zip(unwanted.at[surplus], unwanted.piece[surplus], strict=True):
            near = reach(at, ~cells, options.removed_share)
            patched[_patch(state, at, int(p), most, near, np.inf)] = False
        patched[wanted.cell] = True
        patched[unwanted.cell] = False
        return patched

    wide = corrected(len(cells), 1.0)
    least = corrected(most, options.sure_added_share) if state.sensor == "lidar" else wide
    far = max(clearances, default=0.0)
    return Taken(wide, least, far, pieces, wanted.piece[missed], unwanted.piece[surplus])


def _chosen(mask: NDArray[np.integer] | Mask, count: int) -> NDArray[np.integer] | Mask:
    if mask.dtype == np.bool_:
        if mask.shape != (count,):
            raise BadInputError(f"mask: expected ({count},), got {mask.shape}")
    elif len(mask) and not 0 <= mask.min() <= mask.max() < count:
        raise BadInputError(f"mask: expected point numbers 0 to {count - 1}")
    return mask if len(mask) else np.empty(0, np.int64)


def _patch(
    state: ObjectState, at: Floats, piece: int, most: int, reach: float, whole: float
) -> Ints:
    """Return at most ``most`` cells of a piece within ``reach`` metres of a click, nearest first.

    If they are a share ``whole`` of the piece, return all of its cells.
    """
    own = np.flatnonzero(state.piece == piece)
    distance = np.linalg.norm(state.center[own] - at, axis=1)
    within = int((distance <= reach).sum())
    near = own[np.argsort(distance, kind="stable")[: min(within, most)]]
    return own if len(own) <= most and len(near) >= whole * len(own) else near


def _clearance(state: ObjectState, at: Floats, border: Mask) -> float:
    """Return the distance (m) of a click from the nearest cell of ``border`` (C,); inf: none."""
    beyond = state.center[border]
    return float(np.linalg.norm(beyond - at, axis=1).min()) if len(beyond) else np.inf
