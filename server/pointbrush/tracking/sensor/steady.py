"""A depth camera that sways, as one in a hand or on a mast does, seen as one at rest.

Turned about itself, a camera sees the very same surfaces; moved by little, nearly so.  What it sees
is then taken as seen from the middle of its way, and all that holds of sensors at rest holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pointbrush.tracking.interface import F32, F64
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensor.lens import Lens


def steadied(lens: Lens, depth: F32, poses: Sequence[F64], options: TrackerOptions) -> Lens | None:
    """The pixel grid in the world of a camera at rest that sees what the sensor saw.

    ``poses`` (4, 4) ``T_world_frame`` of frames all over a run, in each of which the sensor has
    ``lens``; ``depth`` (M,) of what it saw.  None where it goes, or turns, too far.
    """
    way = np.array([pose[:3, :3] @ lens.eye + pose[:3, 3] for pose in poses])
    eye = 0.5 * (way.min(axis=0) + way.max(axis=0))
    near, far = np.percentile(depth, [options.sway.near_percentile, options.sway.far_percentile])
    if (
        np.linalg.norm(way - eye, axis=1).max() * (1.0 / near - 1.0 / far)
        > options.sway.max_parallax
    ):
        return None
    to = lens.T_picture_frame[:3, :3]
    low, pitch = np.array(lens.least), np.array(lens.pitch)
    size = pitch * lens.shape[::-1]
    corners = low + size * [[0, 0], [0, 1], [1, 0], [1, 1]]
    rays = np.hstack([corners, np.ones((4, 1))])
    turned = np.concatenate([rays @ (to @ pose[:3, :3] @ to.T).T for pose in poses])
    if turned[:, 2].min() <= 0.0:
        return None
    plane = turned[:, :2] / turned[:, 2:]
    least, most = plane.min(axis=0), plane.max(axis=0)
    if (most - least > options.sway.max_extent * size).any():
        return None
    least, most = least - options.sway.margin_share * size, most + options.sway.margin_share * size
    pitch = pitch * (options.lens.pixel_spacings if lens.lattice else 1.0)
    across, down = np.ceil((most - least) / pitch).astype(int).tolist()
    return replace(
        lens,
        eye=eye.astype(np.float32),
        least=(float(least[0]), float(least[1])),
        pitch=(float(pitch[0]), float(pitch[1])),
        shape=(down, across),
        lattice=False,
    )
