"""Labels of points from masks of pictures.

1. A depth buffer finds the points that a camera sees (``visibility``).
2. The camera's position is corrected by the borders of the mask (``align``).
3. A point is certain if the mask has one value within the error of the calibration around its
   pixel.  All points of a lattice are certain.
4. A point near a border takes the value of the certain points around it in space if they have its
   own value or agree on another: at a jump of depth they lie on its surface.  Otherwise it stays in
   doubt.
5. Each camera has a vote for each point.
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
"""Class of an undecided point: near a border of a mask, or cameras disagree."""
_UNSEEN = -2
"""Class of a point that no mask gives a value."""
_DEFAULTS = LiftOptions()

Mask = NDArray[np.unsignedinteger]
Classes = NDArray[np.int32]


def lift(
    views: Sequence[tuple[View, Mask]],
    xyz: NDArray[np.floating],
    options: LiftOptions = _DEFAULTS,
) -> Classes:
    """Return a class (N,) for each of the points (N, 3): the value of the mask at its pixel.

    ``views``: one or more masks (H, W) with the points in their pictures.  0: the value is 0, or no
    camera sees the point in a pixel with a value; IN_DOUBT: undecided.  VOID is no value.
    Raises BadInputError for a mask of another size than its picture.
    """
    votes = [lift_one(view, mask, xyz, options) for view, mask in views]
    classes = vote(np.stack(votes)) if len(votes) > 1 else votes[0]
    return np.where(classes == _UNSEEN, 0, classes).astype(np.int32)


def lift_one(view: View, mask: Mask, xyz: NDArray[np.floating], options: LiftOptions) -> Classes:
    """Return the classes (N,) of points (N, 3) by one mask, _UNSEEN if it does not give a value."""
    view.require_mask(mask)
    classes = np.full(len(view.pixel), _UNSEEN, np.int32)
    seen, metre_error = visible(view, options.visibility), options.metre_error
    if not view.exact and (offset := align(view, seen, mask, options)) is not None:
        view, metre_error = view.moved(offset), metre_error * options.aligned_error
        seen = seen[view.pixel[seen] >= 0]
    values = mask.ravel()[view.pixel[seen]].astype(np.int32)
    seen, values = seen[values != VOID], values[values != VOID]
    classes[seen] = values
    if view.exact or not len(seen):
        return classes
    error = options.pixel_error + view.focal * metre_error / view.depth[seen]
    border = border_distance(mask)[view.pixel[seen]] <= error
    width = error[border] * view.depth[seen[border]] / view.focal
    resolved = resolve(
        (xyz[seen[~border]], values[~border]), (xyz[seen[border]], values[border]), width, options
    )
    if (mask == VOID).any():
        # A mask with void pixels is drawn from points or omits its borders: its values are exact.
        resolved[resolved != values[border]] = IN_DOUBT
    classes[seen[border]] = resolved
    return classes


def resolve(
    certain: tuple[NDArray[np.floating], Classes],
    border: tuple[NDArray[np.floating], Classes],
    width: NDArray[np.floating],
    options: LiftOptions,
) -> Classes:
    """Return the classes (M,) of points near a border by the certain points around them.

    ``certain`` and ``border``: points (K, 3) and (M, 3) with their values of the mask; ``width``
    (M,): that of the band along the border at each point, metres.  A point keeps its value if the
    nearest certain point has it, and takes the value of all nearest ones if they agree on another:
    it lies on their side of a jump of depth.  Otherwise it is IN_DOUBT.
    """
    from scipy.spatial import cKDTree  # slow to import

    (xyz, values), (places, own) = certain, border
    count = options.neighbours
    if len(xyz) < count or not len(own):
        return np.full(len(own), IN_DOUBT, np.int32)
    distances, numbers = cKDTree(xyz).query(places, k=range(1, count + 1))
    around = values[np.asarray(numbers)]
    far = np.asarray(distances) > (options.most_distance * width)[:, None]
    agreed = (around == around[:, :1]).all(axis=1) & ~far.any(axis=1)
    decided = agreed | ((around[:, 0] == own) & ~far[:, 0])
    return np.where(decided, around[:, 0], IN_DOUBT).astype(np.int32)


def vote(votes: Classes) -> Classes:
    """Return the class (N,) that most cameras give each point, from ``votes`` (C, N).

    IN_DOUBT: a tie, or no camera gives a value and at least one is in doubt.
    """
    best = np.where((votes == IN_DOUBT).any(axis=0), IN_DOUBT, _UNSEEN).astype(np.int32)
    most, tied = np.zeros(best.shape, np.int64), np.zeros(best.shape, np.bool_)
    for camera in votes:
        count = ((votes == camera) & (camera >= 0)).sum(axis=0)
        tied = np.where(count > most, False, tied | ((count == most) & (camera != best)))
        best = np.where(count > most, camera, best).astype(np.int32)
        most = np.maximum(count, most)
    return np.where(tied & (most > 0), IN_DOUBT, best).astype(np.int32)
