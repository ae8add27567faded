"""The box between two hands, and the clip box.

The brush takes every point inside an oriented box; points outside the clip box are not shown, so
that rays pass them and strokes leave them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.geometry.quaternions import quaternion_of, rotation_of
from pointbrush.selection.points import Alive, Points
from pointbrush.selection.shape import Numbers, Parameter, Parts, Selecting, Shape, Values


def box(
    points: Points,
    center: NDArray[np.float64],
    size: NDArray[np.float64],
    rotation: NDArray[np.float64],
) -> Iterator[NDArray[np.int64]]:
    """Yield the sorted numbers of the points in the box, in parts.

    ``center`` (3,) local metres, ``size`` (3,) full edges, ``rotation`` (3, 3) box axes as columns.
    """
    reach = np.abs(rotation) @ (size / 2)
    for blocks in points.groups(points.blocks_in_box(center - reach, center + reach)):
        numbers = points.numbers(blocks)
        yield numbers[inside(points.xyz[numbers], center, size, rotation)]


def inside(
    xyz: NDArray[np.float32],
    center: NDArray[np.float64],
    size: NDArray[np.float64],
    rotation: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Mark the points (n, 3) inside the box, its faces included."""
    off = np.abs((xyz.astype(np.float64) - center) @ rotation)
    return np.asarray((off <= size / 2).all(axis=1))


class _Rotation(Numbers):
    """A quaternion x, y, z, w of any length but zero."""

    def read(self, name: str, value: object) -> NDArray[np.float64]:
        """Return the quaternion.  Raises BadInputError."""
        quaternion = super().read(name, value)
        rotation_of(quaternion)
        return quaternion


def _take(at: Selecting) -> Parts:
    values = at.values
    return box(at.points, values["center"], values["size"], rotation_of(values["quaternion"]))


def placed_box(values: Values, T_new_old: NDArray[np.float64]) -> Values:
    """Return a box's parameters in other coordinates, by a rigid transform (4, 4)."""
    turn = T_new_old[:3, :3]
    center = turn @ values["center"] + T_new_old[:3, 3]
    if (turn == np.eye(3)).all():
        return {**values, "center": center}
    quaternion = quaternion_of(turn @ rotation_of(values["quaternion"]))
    return {**values, "center": center, "quaternion": quaternion}


BOX = Shape(
    "box",
    "The inside of a box.",
    (
        Parameter("center", Numbers(3), None, "metres"),
        Parameter("size", Numbers(3, positive=True), None, "full edge lengths, metres"),
        Parameter("quaternion", _Rotation(4), (0.0, 0.0, 0.0, 1.0), "orientation x, y, z, w"),
    ),
    take=_take,
    sampled=False,
    placed=placed_box,
)


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """A box with the parameters of the shape ``box``, faces included."""

    values: Values

    @classmethod
    def parse(cls, value: Mapping[str, Any] | None) -> Clip | None:
        """Read a stroke's ``clip``: ``center``, ``size``, ``quaternion``; None stays None.

        Raises BadInputError.
        """
        if value is None:
            return None
        try:
            return cls(BOX.read(value))
        except BadInputError as error:
            raise BadInputError(f"clip: {error}") from None

    def placed(self, T_new_old: NDArray[np.float64]) -> Clip:
        """Return the same box in other coordinates, by a rigid transform (4, 4)."""
        return Clip(placed_box(self.values, T_new_old))

    def holds(self, xyz: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Mark the points (n, 3) inside."""
        values = self.values
        return inside(xyz, values["center"], values["size"], rotation_of(values["quaternion"]))

    def of(self, points: Points, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the stored ``numbers`` (n,) of points inside."""
        return numbers[self.holds(points.xyz[numbers])]

    def alive(self, points: Points, alive: Alive | None) -> Alive:
        """Return a function that marks points that rays can hit: ``alive`` ones inside."""

        def both(numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
            held = self.holds(points.xyz[numbers])
            if alive is not None:
                held[held] = alive(numbers[held])
            return held

        return both


def clipped(clip: Clip | None, points: Points, alive: Alive | None) -> Alive | None:
    """Return a function that marks points that rays can hit, limited to ``clip`` if given."""
    return alive if clip is None else clip.alive(points, alive)
