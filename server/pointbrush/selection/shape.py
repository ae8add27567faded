"""A brush shape: its name, its parameters, and the points that it takes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.parameters import Parameter
from pointbrush.selection.points import Points
from pointbrush.selection.pointset import PointSet

if TYPE_CHECKING:
    from pointbrush.selection.ray import Alive
    from pointbrush.selection.stroke import Stroke

Values = Mapping[str, Any]
"""A stroke's parameters by name, read."""


@dataclass(frozen=True, slots=True, eq=False)
class Selecting:
    """A stroke at work: ``stroke`` in local coordinates on ``points``.

    ``alive`` says which points rays can hit; ``taken`` holds what the stroke has taken so far, the
    parts yielded included.
    """

    points: Points
    stroke: Stroke
    alive: Alive | None
    taken: PointSet


Parts = Iterator[NDArray[np.int64]]
"""Stored numbers of points in parts, each sorted."""


@dataclass(frozen=True, slots=True)
class Shape:
    """One shape of a brush.

    ``sampled``: it needs samples; else its parameters say all.  ``sweeps``: a batch of samples
    goes on from the last sample of the batch before.  ``fills``: a later sample takes nothing in
    what an earlier one has taken.  ``meets`` says of the parameters whether rays look for the
    first surface.  ``placed`` turns parameters that have a place into other coordinates, by a
    rigid transform (4, 4) from the old to the new ones.
    """

    name: str
    about: str
    parameters: tuple[Parameter, ...]
    take: Callable[[Selecting], Parts]
    sampled: bool = True
    sweeps: bool = False
    fills: bool = False
    meets: Callable[[Values], bool] = field(default=lambda _values: False)
    placed: Callable[[Values, NDArray[np.float64]], Values] | None = None

    def read(self, fields: Mapping[str, Any]) -> Values:
        """Return the parameters among a stroke's fields.  Raises BadInputError."""
        return {each.name: each.read(fields) for each in self.parameters}
