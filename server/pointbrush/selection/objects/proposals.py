"""All regions that clicks can mean, with what the value model is told of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.objects.clicks import Clicks, kept_cells
from pointbrush.selection.objects.options import ObjectOptions
from pointbrush.selection.objects.state import ObjectState
from pointbrush.selection.objects.taken import Taken, taken_so_far
from pointbrush.selection.objects.unions import Unions, find_unions
from pointbrush.selection.objects.value import value_features

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Proposals:
    """``unions`` of pieces and their ``features`` (n, VALUES); with something ``taken`` the last
    is that.  ``open_`` (C,) cells that are not nearer to an unwanted click on the same piece."""

    unions: Unions
    features: NDArray[np.float64]
    taken: Taken | None
    open_: Mask

    def points(self, state: ObjectState, i: int) -> NDArray[np.int64]:
        """Return the point numbers of a proposal, ascending."""
        cells = np.append(self.cells(state, i), False)  # the last one for points without a cell
        return np.flatnonzero(cells[state.of_point])

    def cells(self, state: ObjectState, i: int) -> Mask:
        """Return which cells (C,) a proposal holds.

        Of what is taken only the pieces change that the proposal adds or leaves out as a whole.
        """
        mask = self.unions.masks[i]
        if self.taken is None:
            return np.asarray(mask[state.piece] & self.open_)
        added, removed = mask & ~self.taken.pieces, self.taken.pieces & ~mask
        return np.asarray(
            self.taken.cells & ~removed[state.piece] | added[state.piece] & self.open_
        )


def propose(
    state: ObjectState,
    wanted: Clicks,
    unwanted: Clicks,
    mask: NDArray[np.integer] | Mask | None,
    options: ObjectOptions,
) -> Proposals:
    """Return all regions for some clicks.  Raises BadInputError for a mask out of range."""
    taken = taken_so_far(state, mask, wanted, unwanted, options.patches)
    unions = find_unions(state, wanted, unwanted, taken, options.ladder.times)
    pieces = None if taken is None else taken.pieces
    features = value_features(state, unions, wanted, unwanted, pieces)
    return Proposals(unions, features, taken, kept_cells(state, wanted, unwanted))
