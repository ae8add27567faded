"""Conventions of tools for boxes, one description for both reading and writing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.boxes.figures import FrameBox
from pointbrush.geometry.oriented_box import Attributes
from pointbrush.geometry.quaternions import quaternion_of, rotation_of
from pointbrush.geometry.rotations import euler_angles, euler_matrix

Floats = NDArray[np.float64]
Turn = Literal["xyz", "zyx", "y", "z", "wxyz", "xyzw"]
"""Numbers of a rotation: angles about x, y and z by the order of their factors, one angle about y
or z alone (the box stays upright), or a quaternion."""
_UPRIGHT = ("y", "z")


@dataclass(frozen=True, slots=True, eq=False)
class Convention:
    """Place, size and rotation of a tool's boxes, as numbers.

    ``sizes``: for each number of a size, 0, 1 or 2 for length, width or height.  ``axes``
    (3, 3): forward, left and up as columns, in the axes of the tool's object.  ``on_bottom``: the
    place is the middle of the bottom, not the centre.
    """

    turn: Turn
    sizes: tuple[int, int, int] = (0, 1, 2)
    degrees: bool = False
    on_bottom: bool = False
    axes: Floats = field(default_factory=lambda: np.eye(3))

    @property
    def upright(self) -> bool:
        """Whether roll and pitch are lost."""
        return self.turn in _UPRIGHT

    def decode(self, place: Floats, size: Floats, turn: Floats) -> tuple[Floats, Floats, Floats]:
        """Compute centre (3,), size (3,) length width height, and rotation (3, 3) of a box's axes
        from the numbers of a file."""
        own = np.empty(3)
        own[list(self.sizes)] = size
        R = self._rotation(turn)
        return place + R[:, 2] * own[2] / 2 * self.on_bottom, own, R

    def encode(
        self, center: Floats, size: Floats, rotation: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Compute the numbers of a file: place (3,), size (3,), rotation (1,), (3,) or (4,)."""
        turn = self._turn(rotation)
        up = self._rotation(turn)[:, 2]
        return center - up * size[2] / 2 * self.on_bottom, size[list(self.sizes)], turn

    def _rotation(self, turn: Floats) -> Floats:
        turn = np.radians(turn) if self.degrees else turn
        match self.turn:
            case "xyzw":
                R = rotation_of(turn)
            case "wxyz":
                R = rotation_of(turn[[1, 2, 3, 0]])
            case "y":
                R = euler_matrix(np.array([0.0, turn[0], 0.0]), "zyx")
            case "z":
                R = euler_matrix(np.array([0.0, 0.0, turn[0]]), "zyx")
            case _:
                R = euler_matrix(turn, self.turn)
        return np.asarray(R @ self.axes)

    def _turn(self, rotation: Floats) -> Floats:
        R = rotation @ self.axes.T
        match self.turn:
            case "xyzw":
                return quaternion_of(R)
            case "wxyz":
                return quaternion_of(R)[[3, 0, 1, 2]]
            case "y":
                turn = np.array([np.arctan2(-R[2, 0], R[0, 0])])
            case "z":
                turn = np.array([np.arctan2(R[1, 0], R[0, 0])])
            case _:
                turn = euler_angles(R, self.turn)
        return np.degrees(turn) if self.degrees else turn


KITTI_AXES = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
"""An object of KITTI has x ahead, y down and z to its left."""
CONVENTIONS: Mapping[str, Convention] = MappingProxyType({
    "labelcloud": Convention("zyx", degrees=True),
    "labelcloud-radians": Convention("zyx"),
    "sustechpoints": Convention("xyz"),
    "xtreme1": Convention("xyz"),
    "supervisely": Convention("zyx"),
    "supervisely-cvat": Convention("xyz"),
    "datumaro": Convention("xyz"),
    "tracklets": Convention("zyx", on_bottom=True),
    "tracklets-cvat": Convention("xyz"),
    "kitti": Convention("y", sizes=(2, 1, 0), on_bottom=True, axes=KITTI_AXES),
    "kitti-untransformed": Convention("z", sizes=(2, 1, 0)),
    "openpcdet": Convention("z"),
    "nuscenes": Convention("wxyz", sizes=(1, 0, 2)),
    "argoverse": Convention("wxyz"),
    "segments": Convention("xyzw"),
    "waymo": Convention("z"),
})  # fmt: skip
"""By tool, or by the tool's format; docs/conventions.md lists the sources."""


def box_by(
    tool: str,
    name: str,
    key: str,
    place: Floats,
    size: Floats,
    turn: Floats,
    *,
    attributes: Attributes | None = None,
) -> FrameBox:
    """Make a box of the numbers that a tool has for it; ``name`` and ``key`` as of FrameBox."""
    center, own, rotation = CONVENTIONS[tool].decode(place, size, np.atleast_1d(turn))
    return FrameBox(name, key, center, own, rotation, attributes=attributes or {})


def numbers_by(tool: str, box: FrameBox) -> tuple[list[float], list[float], list[float]]:
    """Compute the numbers that a tool has for a box: place, size and rotation."""
    place, size, turn = CONVENTIONS[tool].encode(box.center, box.size, box.rotation)
    return place.tolist(), size.tolist(), turn.tolist()
