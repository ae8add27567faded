"""The clip box: points outside it are not shown, so that rays pass them and strokes leave them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.box import BOX, inside, placed_box, rotation_of
from pointbrush.selection.points import Points
from pointbrush.selection.ray import Alive
from pointbrush.selection.shape import Values


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """A box with the parameters of the shape ``box``; what lies on its faces is inside."""

    values: Values

    @classmethod
    def parse(cls, value: object) -> Clip | None:
        """Read a stroke's ``clip``: ``center``, ``size``, ``quaternion``; None stays None.

        Raises BadInputError.
        """
        if value is None:
            return None
        if not isinstance(value, Mapping):
            raise BadInputError(
                f"clip: expected a box with center and size, got {str(value)[:80]!r}"
            )
        fields: Mapping[str, Any] = value
        unknown = fields.keys() - {parameter.name for parameter in BOX.parameters}
        if unknown:
            raise BadInputError(f"clip: expected center, size and quaternion, got {min(unknown)!r}")
        try:
            return cls(BOX.read(fields))
        except BadInputError as error:
            raise BadInputError(f"clip: {error}") from None

    def placed(self, T_new_old: NDArray[np.float64]) -> Clip:
        """Return the same box in other coordinates, by a rigid transform (4, 4)."""
        return Clip(placed_box(self.values, T_new_old))

    def holds(self, xyz: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Return which of points (n, 3) lie inside."""
        values = self.values
        return inside(xyz, values["center"], values["size"], rotation_of(values["quaternion"]))

    def of(self, points: Points, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return those of stored ``numbers`` (n,) that lie inside."""
        return numbers[self.holds(points.xyz[numbers])]

    def alive(self, points: Points, alive: Alive | None) -> Alive:
        """Return which points rays can hit: those inside among the ones that are ``alive``."""

        def both(numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
            held = self.holds(points.xyz[numbers])
            if alive is not None:
                held[held] = alive(numbers[held])
            return held

        return both


def clipped(clip: Clip | None, points: Points, alive: Alive | None) -> Alive | None:
    """Return which points rays can hit with ``clip`` over them, where there is one."""
    return alive if clip is None else clip.alive(points, alive)
