"""Labels of points from masks of pictures.

1. The points that a camera sees are found by a depth buffer (``visibility``).
2. A point is certain if the mask has one value within the error of the calibration around its
   pixel.  A pixel of a lattice is certain.
3. Before, the camera's position is corrected by the borders of the mask (``align``).
4. A point near a border of the mask takes the value of the certain points around it in space, if
   these agree with it or with each other: at a jump of depth they lie on its surface.  Otherwise it
   stays in doubt.
5. Cameras vote.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.masks.align import align
from pointbrush.masks.borders import border_distance
from pointbrush.masks.options import LiftOptions
from pointbrush.masks.views import View
from pointbrush.masks.visibility import visible
from pointbrush.values.masks import VOID

IN_DOUBT = -1
"""Class of a point near a border of a mask, or that cameras disagree about."""
_UNSEEN = -2
_DEFAULTS = LiftOptions()

Mask = NDArray[np.unsignedinteger]
Classes = NDArray[np.int32]


def lift(
    views: Sequence[tuple[View, Mask]],
    xyz: NDArray[np.floating],
    options: LiftOptions = _DEFAULTS,
) -> Classes:
    """Return a class (N,) for each of the points (N, 3): the value of the mask where it is seen.

    0: not seen, or seen in a pixel with value 0; IN_DOUBT: unknown.  A pixel with value VOID says
    nothing about its points.  Raises BadInputError for a mask of another size than its picture.
    """
    votes = [lift_one(view, mask, xyz, options) for view, mask in views]
    found = vote(np.stack(votes)) if len(votes) > 1 else votes[0]
    return np.where(found == _UNSEEN, 0, found).astype(np.int32)


def lift_one(view: View, mask: Mask, xyz: NDArray[np.floating], options: LiftOptions) -> Classes:
    """Return the classes (N,) by one mask; -2 for points that it says nothing about."""
    view.require_mask(mask)
    found = np.full(len(view.pixel), _UNSEEN, np.int32)
    seen, metre_error = visible(view, options.visibility), options.metre_error
    if not view.exact and (offset := align(view, seen, mask, options)) is not None:
        view, metre_error = view.moved(offset), metre_error * options.aligned_error
        seen = seen[view.pixel[seen] >= 0]
    values = mask.ravel()[view.pixel[seen]].astype(np.int32)
    seen, values = seen[values != VOID], values[values != VOID]
    found[seen] = values
    if view.exact or not len(seen):
        return found
    error = options.pixel_error + view.focal * metre_error / view.depth[seen]
    doubtful = border_distance(mask)[view.pixel[seen]] <= error
    found[seen[doubtful]] = IN_DOUBT
    width = error[doubtful] * view.depth[seen[doubtful]] / view.focal
    resolved = resolve(
        (xyz[seen[~doubtful]], values[~doubtful]),
        (xyz[seen[doubtful]], values[doubtful]),
        width,
        options,
    )
    if (mask == VOID).any():
        # Such a mask was drawn of points, or leaves its borders out: its values are exact.
        resolved[resolved != values[doubtful]] = IN_DOUBT
    found[seen[doubtful]] = resolved
    return found


def resolve(
    certain: tuple[NDArray[np.floating], Classes],
    doubtful: tuple[NDArray[np.floating], Classes],
    width: NDArray[np.floating],
    options: LiftOptions,
) -> Classes:
    """Return the classes (M,) of doubtful points by the certain ones around them, or IN_DOUBT.

    Both are points (K, 3), (M, 3) with values of the mask; ``width`` (M,) of the doubtful band at
    each point, metres.  A point keeps its value if the nearest certain point has it, and takes
    that of all nearest ones if they agree on another: it lies on their side of a jump of depth.
    """
    from scipy.spatial import cKDTree  # slow to import

    (xyz, values), (places, own) = certain, doubtful
    count = options.neighbours
    if len(xyz) < count or not len(own):
        return np.full(len(own), IN_DOUBT, np.int32)
    answer = cKDTree(xyz).query(places, k=range(1, count + 1))
    found = values[np.asarray(answer[1])]
    far = np.asarray(answer[0]) > (options.most_distance * width)[:, None]
    agreed = (found == found[:, :1]).all(axis=1) & ~far.any(axis=1)
    certain_ones = agreed | ((found[:, 0] == own) & ~far[:, 0])
    return np.where(certain_ones, found[:, 0], IN_DOUBT).astype(np.int32)


def vote(votes: Classes) -> Classes:
    """Return the classes (N,) that most of the cameras (C, N) give; IN_DOUBT for a tie."""
    best = np.where((votes == IN_DOUBT).any(axis=0), IN_DOUBT, _UNSEEN).astype(np.int32)
    most, tied = np.zeros(best.shape, np.int64), np.zeros(best.shape, np.bool_)
    for camera in votes:
        count = ((votes == camera) & (camera >= 0)).sum(axis=0)
        tied = np.where(count > most, False, tied | ((count == most) & (camera != best)))
        best = np.where(count > most, camera, best).astype(np.int32)
        most = np.maximum(count, most)
    return np.where(tied & (most > 0), IN_DOUBT, best).astype(np.int32)
