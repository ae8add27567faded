"""Connected pieces of a label's points, and the one that lies far from the rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.cluster import touching
from pointbrush.work.reviewing.checks.options import CheckOptions

F64 = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Stray:
    """Points far from their object: their share 0..1, how far in metres, and a place among them."""

    share: float
    distance: float
    place: tuple[float, float, float]


def find_stray(xyz: F64, options: CheckOptions) -> Stray | None:
    """Return the farthest piece of points (N, 3) that is far from the largest one, or None."""
    from scipy.spatial import cKDTree  # a server that answers has not loaded it

    if len(xyz) < 2:
        return None
    nearest = np.asarray(cKDTree(xyz).query(xyz, k=[2])[0])
    piece = pieces(xyz, max(options.link, options.spacing * float(np.median(nearest))))
    sizes = np.bincount(piece)
    if len(sizes) == 1:
        return None
    main = xyz[piece == sizes.argmax()]
    far = max(options.stray, options.stray_extent * float(np.linalg.norm(np.ptp(main, axis=0))))
    others = piece != sizes.argmax()
    away = cKDTree(main).query(xyz[others])[0]
    # A piece is as far as its nearest point.
    near = np.full(len(sizes), np.inf)
    np.minimum.at(near, piece[others], away)
    near[sizes.argmax()] = 0.0
    found = np.flatnonzero(near > far)
    if not len(found):
        return None
    worst = found[np.argmax(sizes[found])]
    x, y, z = (float(value) for value in np.median(xyz[piece == worst], axis=0))
    share = float(sizes[found].sum() / len(xyz))
    return Stray(share, float(near[worst]), (x, y, z))


def pieces(xyz: F64, cell: float) -> NDArray[np.int64]:
    """Return the piece (N,) that each point is of: points in touching cells of ``cell`` metres."""
    return touching(np.floor(xyz / cell).astype(np.int64))
