"""Interpolation of poses at the times of frames from a list of poses with other times."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError

log = logging.getLogger(__name__)
Pose = NDArray[np.float64]
NEAR = 0.02
"""Greatest seconds between files of one frame, as in the tools of the TUM benchmark."""
SAME = 1e-6
"""Greatest seconds between two times that count as equal, for times with rounded digits."""
MOST_GAP = 2.0
"""Greatest seconds between two poses for an interpolated one."""


def interpolated(
    name: str, stamps: Sequence[float], poses: Sequence[Pose], times: Sequence[float]
) -> list[Pose | None]:
    """Interpolate poses (4, 4) of ``stamps`` at ``times``, all in seconds: positions linearly,
    rotations on the shortest arc (slerp).

    None, with a warning, for a time that is neither within NEAR of a pose nor between two poses at
    most MOST_GAP apart.  Raises BadInputError naming ``name`` if this applies to all times.
    """
    from scipy.spatial.transform import Rotation, Slerp

    at, first = np.unique(np.asarray(stamps, np.float64), return_index=True)
    matrices = np.stack([poses[i] for i in first.tolist()])
    wanted = np.asarray(times, np.float64)
    after = np.searchsorted(at, wanted).clip(1, max(len(at) - 1, 1))
    before, after = after - 1, np.minimum(after, len(at) - 1)
    apart = np.abs(at[[before, after]] - wanted)
    nearest = apart.min(axis=0)
    wanted = np.where(nearest < SAME, at[np.where(apart[0] <= apart[1], before, after)], wanted)
    between = (at[before] <= wanted) & (wanted <= at[after]) & (at[after] - at[before] <= MOST_GAP)
    known = between | (nearest <= NEAR)
    if not known.any():
        raise BadInputError(
            f"{name}: expected poses at the times of the frames, {wanted.min():.3f} to "
            f"{wanted.max():.3f} s, got poses of {at[0]:.3f} to {at[-1]:.3f} s"
        )
    if not known.all():
        log.warning(
            "%s: %d of %d frames have no pose: it has none within %g s of their times, nor two at "
            "most %g s apart round them",
            name, np.count_nonzero(~known), len(known), NEAR, MOST_GAP,
        )  # fmt: skip
    inside = wanted.clip(at[0], at[-1])
    made = np.tile(np.eye(4), (len(wanted), 1, 1))
    rotations = Rotation.from_matrix(matrices[:, :3, :3])
    turned = Slerp(at, rotations)(inside) if len(at) > 1 else rotations[np.zeros(len(wanted), int)]
    made[:, :3, :3] = turned.as_matrix()
    for axis in range(3):
        made[:, axis, 3] = np.interp(inside, at, matrices[:, axis, 3])
    return [pose if is_known else None for pose, is_known in zip(made, known, strict=True)]
