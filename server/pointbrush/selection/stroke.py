"""What a person drew: samples of a controller or mouse, and the brush that it held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError

TOOLS = ("paint", "erase", "delete", "restore")
SHAPES = ("sphere", "ray", "lasso", "box", "grow", "plane")
MAX_SAMPLES = 65_536
MAX_POLYGON = 4_096
MAX_HIDDEN = 65_535
"""All label ids, and 0."""


@dataclass(frozen=True, eq=False)
class Lasso:
    """``polygon`` (V, 2) in normalised device coordinates; ``matrix`` (4, 4) clip_from_points."""

    polygon: NDArray[np.float64]
    matrix: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Box:
    """``center`` (3,) metres, ``size`` (3,) full edges, ``rotation`` (3, 3) box axes as columns."""

    center: NDArray[np.float64]
    size: NDArray[np.float64]
    rotation: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Stroke:
    """A validated stroke; coordinates are metres, in source or local coordinates.

    ``origins``, ``directions``  (S, 3) float64; directions are unit length.
    ``lasso`` and ``box`` hold the region of the shapes of that name.
    ``hidden`` are labels that only the viewer hides; 0: points without a label.

    Raises BadInputError, saying what was expected and what came.
    """

    shape: str
    tool: str = "paint"
    label: int = 0
    radius: float = 0.05
    origins: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    directions: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    only_unlabeled: bool = False
    through: bool = False
    hidden: frozenset[int] = frozenset()
    lasso: Lasso | None = None
    box: Box | None = None

    @classmethod
    def parse(cls, fields: Mapping[str, Any]) -> Stroke:
        """Build from the contract's JSON fields (``samples`` as objects); see the class."""
        shape, tool = fields.get("shape", "sphere"), fields.get("tool", "paint")
        if shape not in SHAPES:
            raise BadInputError(f"shape: expected one of {', '.join(SHAPES)}, got {shape!r}")
        if tool not in TOOLS:
            raise BadInputError(f"tool: expected one of {', '.join(TOOLS)}, got {tool!r}")
        stroke = cls(
            shape=shape,
            tool=tool,
            label=_label(fields.get("label", 0), tool),
            radius=_radius(fields.get("radius", 0.05)),
            only_unlabeled=bool(fields.get("only_unlabeled", False)),
            through=bool(fields.get("through", False)),
            hidden=_hidden(fields.get("hidden", ())),
        )
        stroke = stroke.with_samples(fields.get("samples") or [])
        if shape == "lasso":
            return replace(stroke, lasso=_lasso(fields))
        if shape == "box":
            return replace(stroke, box=_box(fields))
        return stroke

    def with_samples(self, samples: Sequence[Mapping[str, Any]]) -> Stroke:
        """This stroke with these samples (``origin``, ``direction``) in place of its own."""
        if len(samples) > MAX_SAMPLES:
            raise BadInputError(
                f"samples: expected at most {MAX_SAMPLES:,} samples, got {len(samples):,}"
            )
        origins = [sample.get("origin") for sample in samples]
        directions = [sample.get("direction", (0.0, 0.0, -1.0)) for sample in samples]
        return replace(
            self,
            origins=_rows("samples.origin", origins, 3),
            directions=_unit(_rows("samples.direction", directions, 3)),
        )

    def to_local(self, shift: NDArray[np.float64]) -> Stroke:
        """The same stroke in local coordinates (source minus ``shift``)."""
        if not shift.any():
            return self
        T_source_local = np.eye(4)
        T_source_local[:3, 3] = shift
        lasso, box = self.lasso, self.box
        return replace(
            self,
            origins=self.origins - shift,
            lasso=lasso and replace(lasso, matrix=lasso.matrix @ T_source_local),
            box=box and replace(box, center=box.center - shift),
        )


def _label(value: object, tool: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 65534:
        raise BadInputError(f"label: expected an integer 0 to 65534, got {value!r}")
    if tool == "paint" and value == 0:
        raise BadInputError("label: expected 1 to 65534 to paint with, got 0 (use tool 'erase')")
    return value


def _hidden(values: object) -> frozenset[int]:
    if not isinstance(values, list | tuple) or len(values) > MAX_HIDDEN:
        raise BadInputError(f"hidden: expected at most {MAX_HIDDEN:,} label ids in a list")
    for value in values:
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= 65534:
            raise BadInputError(f"hidden: expected integers 0 to 65534, got {str(value)[:80]!r}")
    return frozenset(values)


def _radius(value: object) -> float:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not 0 < float(value) <= 1000:  # type: ignore[arg-type]
        raise BadInputError(f"radius: expected metres above 0 and up to 1000, got {value!r}")
    return float(value)  # type: ignore[arg-type]


def _rows(name: str, values: Sequence[Any], width: int) -> NDArray[np.float64]:
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


def _unit(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    # The greatest part first: squares of huge or tiny ones are no numbers any more.
    largest = np.abs(directions).max(axis=1, keepdims=True, initial=0.0)
    if (largest < 1e-12).any():
        bad = int(np.flatnonzero(largest[:, 0] < 1e-12)[0])
        raise BadInputError(
            f"samples.direction: expected a vector with a length, got {directions[bad].tolist()} "
            f"in sample {bad}"
        )
    parts = directions / largest
    return np.asarray(parts / np.linalg.norm(parts, axis=1, keepdims=True))


def _vector(name: str, value: object, shape: tuple[int, ...]) -> NDArray[np.float64]:
    try:
        array = np.array(value, np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.size != np.prod(shape) or not np.isfinite(array).all():
        count = int(np.prod(shape))
        raise BadInputError(f"{name}: expected {count} finite numbers, got {str(value)[:80]}")
    return array.reshape(shape)


def _lasso(fields: Mapping[str, Any]) -> Lasso:
    corners = fields.get("polygon") or []
    if not 3 <= len(corners) <= MAX_POLYGON:
        raise BadInputError(f"polygon: expected 3 to {MAX_POLYGON} corners, got {len(corners)}")
    polygon = _rows("polygon", corners, 2)
    return Lasso(polygon, _vector("matrix", fields.get("matrix"), (4, 4)))


def _box(fields: Mapping[str, Any]) -> Box:
    size = _vector("size", fields.get("size"), (3,))
    if (size <= 0).any():
        raise BadInputError(f"size: expected three edge lengths above 0, got {size.tolist()}")
    quaternion = fields.get("quaternion")
    x, y, z, w = _vector(
        "quaternion", [0.0, 0.0, 0.0, 1.0] if quaternion is None else quaternion, (4,)
    )
    norm = np.sqrt(x * x + y * y + z * z + w * w)
    if norm < 1e-9:
        raise BadInputError(f"quaternion: expected a rotation x, y, z, w, got {quaternion!r}")
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    center = _vector("center", fields.get("center"), (3,))
    return Box(center, size, rotation)
