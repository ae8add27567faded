"""The floor as people point at it: rays that meet it → the transform that stands a recording on it.

Each place that is pointed at says where the surface is, and its surroundings say which way it
faces; far places outweigh surroundings.  One place is enough, three that lie apart level a floor
better than any one of them.
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
"""Radius of a place's first surroundings, for one metre of the recording's diagonal …"""
REACH_LEAST, REACH_MOST = 0.1, 1.0
"""… but no less and no more, metres: a room's floor, and a street's."""
UP = np.array([0.0, 1.0, 0.0])


def room_on_floor(
    store: LabelStore, recording: Recording, frame: int, samples: Sequence[Mapping[str, Any]]
) -> NDArray[np.float64]:
    """``T_room_local`` (4, 4) that stands ``frame`` on the surface that ``samples`` point at.

    ``samples`` are rays in source coordinates, as a stroke's.  The middle of the places keeps its
    place in the room's plan, and the recording its heading.  Raises NotFoundError (frame),
    BadInputError for no samples, or when one of them meets no surface.
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
    """Metres round a place that are looked at first."""
    diagonal = float(np.linalg.norm(np.subtract(manifest.hi, manifest.lo)))
    return float(np.clip(REACH_PART * diagonal, REACH_LEAST, REACH_MOST))


def floor_at(
    points: Points, origins: Vector, directions: Vector, radius: float, alive: Alive | None = None
) -> tuple[Vector, Vector]:
    """Normal (3,), towards who points, and middle (3,) of the plane that rays (S, 3) meet."""
    hits = first_hits(points, origins, directions, radius, alive)
    places, tilts = np.empty_like(hits), np.zeros((3, 3))
    for k, hit in enumerate(hits):
        found = fit_plane(points, hit, radius, alive) if np.isfinite(hit).all() else None
        if found is None:
            raise BadInputError(f"samples: expected a ray that meets a surface, got none in {k}")
        places[k] = hit - found.off(hit) * found.normal
        tilts += np.eye(3) - np.outer(found.normal, found.normal)
    middle = places.mean(axis=0)
    # The normal is at right angles to the ways between the places and, as firmly as a plane of
    # the surroundings' width can say it, to the surfaces there.
    apart = places - middle
    normal = np.linalg.eigh(apart.T @ apart + radius**2 * tilts)[1][:, 0]
    towards = float(((origins - places) @ normal).sum())
    return (normal if towards >= 0 else -normal), middle


def stand_on(T_room_local: Vector, normal: Vector, middle: Vector) -> NDArray[np.float64]:
    """``T_room_local`` (4, 4) turned the shortest way until the plane is the room's floor.

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
    """The rotation (3, 3) that takes a direction to +y by the smallest angle."""
    from scipy.spatial.transform import Rotation

    axis = np.cross(up, UP)
    sine, cosine = float(np.linalg.norm(axis)), float(up @ UP)
    # Upside down: over its side, about x.
    way = axis / sine if sine > 1e-9 else np.array([1.0, 0.0, 0.0])
    matrix: NDArray[np.float64] = Rotation.from_rotvec(way * np.arctan2(sine, cosine)).as_matrix()
    return matrix
