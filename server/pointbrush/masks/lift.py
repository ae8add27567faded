"""Labels of points from masks of pictures.

1. The points that a camera sees are found by a depth buffer (``visibility``).
2. A point is certain if the mask has one value within the error of the calibration around its
   pixel.  A pixel of a lattice is certain.
3. Points near a border of the mask take the class of the certain points around them in space, if
   these agree: at a depth jump they lie on the same surface.  Other points stay in doubt.
4. Cameras vote.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

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
    seen = visible(view, options.visibility)
    values = mask.ravel()[view.pixel[seen]].astype(np.int32)
    seen, values = seen[values != VOID], values[values != VOID]
    found[seen] = values
    if view.exact or not len(seen):
        return found
    error = options.pixel_error + view.focal * options.metre_error / view.depth[seen]
    doubtful = border_distance(mask)[view.pixel[seen]] <= error
    found[seen[doubtful]] = IN_DOUBT
    width = error[doubtful] * view.depth[seen[doubtful]] / view.focal
    found[seen[doubtful]] = resolve(
        xyz[seen[~doubtful]], values[~doubtful], xyz[seen[doubtful]], width, options
    )
    return found


def border_distance(mask: Mask) -> NDArray[np.float32]:
    """Return the distance (H * W,) of each pixel from the nearest pixel of another value, pixels.

    A void pixel counts as the nearest other pixel.
    """
    from scipy.ndimage import distance_transform_edt  # slow to import

    void = mask == VOID
    if void.any() and not void.all():
        row, column = distance_transform_edt(void, return_distances=False, return_indices=True)
        mask = mask[row, column]
    border = np.zeros(mask.shape, np.bool_)
    for axis in (0, 1):
        before, after = _pairs(axis)
        differs = mask[before] != mask[after]
        border[before] |= differs
        border[after] |= differs
    if not border.any():
        return np.full(mask.size, np.inf, np.float32)
    return np.asarray(distance_transform_edt(~border) + 1, np.float32).ravel()


def _pairs(axis: int) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Return the slices of an image that pair each pixel with the next one along an axis."""
    all_of = [slice(None), slice(None)]
    before, after = [*all_of], [*all_of]
    before[axis], after[axis] = slice(None, -1), slice(1, None)
    return tuple(before), tuple(after)


def resolve(
    certain: NDArray[np.floating],
    classes: Classes,
    doubtful: NDArray[np.floating],
    width: NDArray[np.floating],
    options: LiftOptions,
) -> Classes:
    """Return the classes (M,) of doubtful points (M, 3) by certain ones (K, 3), or IN_DOUBT.

    ``classes`` (K,); ``width`` (M,) of the doubtful band at each point, metres.  A class is taken
    if all certain points nearest to the point, within a multiple of ``width``, have it.
    """
    from scipy.spatial import cKDTree  # slow to import

    found = np.full(len(doubtful), IN_DOUBT, np.int32)
    if not len(certain) or not len(doubtful):
        return found
    count = min(options.neighbours, len(certain))
    answer = cKDTree(certain).query(doubtful, k=range(1, count + 1))
    distance, near = np.asarray(answer[0]), np.asarray(answer[1])
    within = distance <= (options.most_distance * width)[:, None]
    first = classes[near[:, 0]]
    agreed = ((classes[near] == first[:, None]) | ~within).all(axis=1) & within[:, 0]
    found[agreed] = first[agreed]
    return found


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
