"""A brush shape: its name, parameters and selected points.

A parameter defines its valid values and the conversion from JSON fields.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.points import Alive, Points, PointSet

Values = Mapping[str, Any]
"""A stroke's converted parameters by name."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number greater than ``above`` and at most ``most``."""

    above: float
    most: float

    def read(self, name: str, value: object) -> float:
        """Return the number.  Raises BadInputError."""
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not self.above < float(value) <= self.most:  # type: ignore[arg-type]
            raise BadInputError(
                f"{name}: expected metres above {self.above:g} and up to {self.most:g}, "
                f"got {value!r}"
            )
        return float(value)  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class Flag:
    """A boolean."""

    def read(self, _name: str, value: object) -> bool:
        """Return the flag."""
        return bool(value)


@dataclass(frozen=True, slots=True)
class Whole:
    """An integer from ``least`` to ``most``; None stays None."""

    least: int
    most: int

    def read(self, name: str, value: object) -> int | None:
        """Return the integer.  Raises BadInputError."""
        if value is None:
            return None
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not whole or not self.least <= value <= self.most:  # type: ignore[operator]
            raise BadInputError(f"{name}: expected {self.least} to {self.most}, got {value!r}")
        return value  # type: ignore[return-value]


@dataclass(frozen=True, slots=True)
class Text:
    """At most ``most`` characters."""

    most: int

    def read(self, name: str, value: object) -> str:
        """Return the text.  Raises BadInputError."""
        if not isinstance(value, str) or len(value) > self.most:
            raise BadInputError(f"{name}: expected at most {self.most} characters, got {value!r}")
        return value


@dataclass(frozen=True, slots=True)
class EditName:
    """The id of an edit, a UUID; None stays None."""

    def read(self, name: str, value: object) -> str | None:
        """Return the id; the label store checks that the edit exists."""
        return None if value is None else Text(36).read(name, value)


@dataclass(frozen=True, slots=True)
class Numbers:
    """Finite numbers in an array of ``shape``; above 0 where ``positive``."""

    shape: tuple[int, ...]
    positive: bool = False

    def read(self, name: str, value: object) -> NDArray[np.float64]:
        """Return the array.  Raises BadInputError."""
        try:
            array = np.array(value, np.float64)
        except (TypeError, ValueError):
            array = np.empty(0)
        count = int(np.prod(self.shape))
        if array.size != count or not np.isfinite(array).all():
            raise BadInputError(f"{name}: expected {count} finite numbers, got {str(value)[:80]}")
        if self.positive and (array <= 0).any():
            raise BadInputError(f"{name}: expected {count} lengths above 0, got {array.tolist()}")
        return array.reshape(self.shape)


@dataclass(frozen=True, slots=True)
class Vertices:
    """``least`` to ``most`` vertices of two finite numbers each."""

    least: int
    most: int

    def read(self, name: str, value: object) -> NDArray[np.float64]:
        """Return the vertices (V, 2).  Raises BadInputError."""
        corners: Any = value if isinstance(value, list | tuple | np.ndarray) else ()
        if not self.least <= len(corners) <= self.most:
            raise BadInputError(
                f"{name}: expected {self.least} to {self.most} corners, got {len(corners)}"
            )
        return rows(name, corners, 2)


@dataclass(frozen=True, slots=True)
class Rays:
    """At most ``most`` samples (``origin``, ``direction``)."""

    most: int

    def read(self, name: str, value: object) -> Sequence[Mapping[str, Any]]:
        """Return the samples.  Raises BadInputError."""
        if not isinstance(value, list | tuple) or len(value) > self.most:
            got = len(value) if isinstance(value, list | tuple) else repr(value)[:80]
            raise BadInputError(f"{name}: expected at most {self.most} rays, got {got}")
        return value


Kind = Number | Flag | Whole | Text | EditName | Numbers | Vertices | Rays


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


RADIUS = Parameter("radius", Number(0, 1000), 0.05, "metres")


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
