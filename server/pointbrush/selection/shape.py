"""A brush shape: its name, parameters and selected points.

A parameter defines its valid values and the conversion from JSON fields.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.points import Alive, Points, PointSet
from pointbrush.values.base import Rule
from pointbrush.values.kinds import Finite

Values = Mapping[str, Any]
"""A stroke's converted parameters by name."""


class Kind:
    """Values of a parameter; calls and messages check them by their ``type``."""

    def __init__(self, type: Any) -> None:
        self.type = type

    def read(self, _name: str, value: Any) -> Any:
        """Return the value of the parameter ``_name`` for strokes.  Raises BadInputError."""
        return value


FLAG = Kind(bool)


def _list_of(item: Any, count: int) -> Any:
    return Annotated[list[item], Rule(min_length=count, max_length=count)]


class Numbers(Kind):
    """Finite numbers in an array of ``shape``; above 0 where ``positive``."""

    def __init__(self, *shape: int, positive: bool = False) -> None:
        super().__init__(_list_of(Finite, math.prod(shape)))
        self.shape, self.positive = shape, positive

    def read(self, name: str, value: object) -> NDArray[np.float64]:
        """Return the array.  Raises BadInputError."""
        try:
            array = np.array(value, np.float64)
        except (TypeError, ValueError):
            array = np.empty(0)
        count = math.prod(self.shape)
        if array.size != count or not np.isfinite(array).all():
            raise BadInputError(f"{name}: expected {count} finite numbers, got {str(value)[:80]}")
        if self.positive and (array <= 0).any():
            raise BadInputError(f"{name}: expected {count} lengths above 0, got {array.tolist()}")
        return array.reshape(self.shape)


class Vertices(Kind):
    """``least`` to ``most`` vertices of two finite numbers each."""

    def __init__(self, least: int, most: int) -> None:
        corner: Any = _list_of(Finite, 2)
        super().__init__(Annotated[list[corner], Rule(max_length=most)])
        self.least, self.most = least, most

    def read(self, name: str, value: object) -> NDArray[np.float64]:
        """Return the vertices (V, 2).  Raises BadInputError."""
        corners: Any = value if isinstance(value, list | tuple | np.ndarray) else ()
        if not self.least <= len(corners) <= self.most:
            raise BadInputError(
                f"{name}: expected {self.least} to {self.most} corners, got {len(corners)}"
            )
        return rows(name, corners, 2)


class Rays(Kind):
    """At most ``most`` samples (``origin``, ``direction``)."""

    def __init__(self, most: int) -> None:
        super().__init__(list)
        self.most = most


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a shape; ``default``: value if the stroke leaves it out, None: no default."""

    name: str
    kind: Kind
    default: Any
    about: str

    def read(self, fields: Mapping[str, Any]) -> Any:
        """Return the value among a stroke's fields.  Raises BadInputError."""
        value = fields.get(self.name)
        return self.kind.read(self.name, self.default if value is None else value)


RADIUS = Parameter(
    "radius", Kind(Annotated[float, Rule(gt=0, le=1000, allow_inf_nan=False)]), 0.05, "metres"
)


def rows(name: str, values: Sequence[Any], width: int) -> NDArray[np.float64]:
    """Return rows (n, width) of finite numbers.  Raises BadInputError."""
    if len(values) == 0:
        return np.empty((0, width))
    try:
        array = np.array(values, np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (len(values), width) or not np.isfinite(array).all():
        raise BadInputError(
            f"{name}: expected {width} finite numbers each, got {str(values[:3])[:80]}"
        )
    return array


def unit(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return directions (S, 3) of length 1.  Raises BadInputError for one without a length."""
    # Scaled by the largest component first: squares of huge or tiny values overflow or underflow.
    largest = np.abs(directions).max(axis=1, keepdims=True, initial=0.0)
    if (largest < 1e-12).any():
        bad = int(np.flatnonzero(largest[:, 0] < 1e-12)[0])
        raise BadInputError(
            f"samples.direction: expected a vector with a length, got {directions[bad].tolist()} "
            f"in sample {bad}"
        )
    parts = directions / largest
    return np.asarray(parts / np.linalg.norm(parts, axis=1, keepdims=True))


@dataclass(frozen=True, slots=True, eq=False)
class Selecting:
    """A stroke applied to ``points``: its parameters and samples, in local coordinates.

    ``origins``, ``directions``, ``met``: see ``Stroke``; ``alive``: marks points that rays can hit;
    ``taken``: points taken so far, including yielded parts.
    """

    points: Points
    values: Values
    origins: NDArray[np.float64]
    directions: NDArray[np.float64]
    met: NDArray[np.float64] | None
    alive: Alive | None
    taken: PointSet

    @property
    def radius(self) -> float:
        """Metres; of shapes that have one."""
        return float(self.values["radius"])


Parts = Iterator[NDArray[np.int64]]
"""Stored numbers of points in parts, each sorted."""


@dataclass(frozen=True, slots=True)
class Shape:
    """One shape of a brush.

    ``sampled``: it needs samples; otherwise the parameters are sufficient.  ``sweeps``: a batch of
    samples continues from the last sample of the previous batch.  ``fills``: samples take no points
    inside the region of an earlier sample.  ``meets``: returns whether, with these parameters, rays
    search for the first surface.  ``placed``: transforms parameters with a position by a rigid
    transform (4, 4) from the old to the new coordinates.
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
