"""The transform that places a recording on its floor, from rays that hit the floor.

Each hit gives a position of the surface, and its surroundings give the orientation; hits that are
far apart outweigh surroundings.  One hit is enough; three distant hits level a floor better than a
single one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.labels import LabelStore
from pointbrush.selection import Points, Stroke, first_hits, fit_plane
from pointbrush.selection.points import Alive
from pointbrush.sequences import Manifest
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.annotate.painted_frame import Seen, frame_points

Vector = NDArray[np.float64]

REACH_PART = 1 / 60
"""Radius of a hit's first surroundings per metre of the recording's diagonal."""
REACH_LEAST, REACH_MOST = 0.1, 1.0
"""Bounds of this radius, metres: for the floor of a room and of a street."""
UP = np.array([0.0, 1.0, 0.0])


def room_on_floor(
    store: LabelStore, recording: Recording, frame: int, samples: Sequence[Mapping[str, Any]]
) -> NDArray[np.float64]:
    """Return ``T_room_local`` (4, 4) that places ``frame`` on the surface hit by ``samples``.

    ``samples`` are rays in source coordinates, as in a stroke.  The centre of the hits keeps its
    horizontal position in the room, and the recording its heading.  Raises NotFoundError (frame),
    BadInputError for no samples, or for a ray without a hit.
    """
    if not samples:
        raise BadInputError("samples: expected at least one ray to the floor, got none")
    manifest = recording.manifest
    pointing = Stroke.parse({"shape": "plane", "tool": "erase", "samples": samples})
    pointing = pointing.to_local(np.asarray(manifest.shift, np.float64))
    points = frame_points(recording[frame])
    shown = Seen(store.view(manifest.id), frame).shown
    normal, middle = floor_at(points, pointing.origins, pointing.directions, reach(manifest), shown)
    return stand_on(manifest.T_room_local, normal, middle)


def reach(manifest: Manifest) -> float:
    """Return the radius of the first surroundings of a hit, metres."""
    diagonal = float(np.linalg.norm(np.subtract(manifest.hi, manifest.lo)))
    return float(np.clip(REACH_PART * diagonal, REACH_LEAST, REACH_MOST))


def floor_at(
    points: Points, origins: Vector, directions: Vector, radius: float, alive: Alive | None = None
) -> tuple[Vector, Vector]:
    """Return the normal (3,), towards the rays' origins, and centre (3,) of the hit plane."""
    hits = first_hits(points, origins, directions, radius, alive)
    places, tilts = np.empty_like(hits), np.zeros((3, 3))
    for k, hit in enumerate(hits):
        found = fit_plane(points, hit, radius, alive) if np.isfinite(hit).all() else None
        if found is None:
            raise BadInputError(f"samples: expected a ray that meets a surface, got none in {k}")
        places[k] = hit - found.off(hit) * found.normal
        tilts += np.eye(3) - np.outer(found.normal, found.normal)
    middle = places.mean(axis=0)
    # Least squares: the normal is perpendicular to the vectors between the hits and, weighted by
    # the squared radius of the surroundings, to the surfaces there.
    apart = places - middle
    normal = np.linalg.eigh(apart.T @ apart + radius**2 * tilts)[1][:, 0]
    towards = float(((origins - places) @ normal).sum())
    return (normal if towards >= 0 else -normal), middle


def stand_on(T_room_local: Vector, normal: Vector, middle: Vector) -> NDArray[np.float64]:
    """Return ``T_room_local`` (4, 4), rotated by the smallest angle so that the plane is the floor.

    ``normal`` and ``middle`` (3,) of the plane are local.
    """
    up = np.linalg.solve(T_room_local[:3, :3].T, normal)
    turn = np.eye(4)
    turn[:3, :3] = _shortest(up / np.linalg.norm(up))
    at = T_room_local[:3, :3] @ middle + T_room_local[:3, 3]
    turn[:3, 3] = at * [1.0, 0.0, 1.0] - turn[:3, :3] @ at
    T_new: NDArray[np.float64] = turn @ T_room_local
    return T_new + 0.0  # no negative zeros


def _shortest(up: Vector) -> NDArray[np.float64]:
    """Return the rotation (3, 3) of a direction to +y by the smallest angle."""
    from scipy.spatial.transform import Rotation

    axis = np.cross(up, UP)
    sine, cosine = float(np.linalg.norm(axis)), float(up @ UP)
    # For -y the axis is not unique: use x.
    way = axis / sine if sine > 1e-9 else np.array([1.0, 0.0, 0.0])
    matrix: NDArray[np.float64] = Rotation.from_rotvec(way * np.arctan2(sine, cosine)).as_matrix()
    return matrix
