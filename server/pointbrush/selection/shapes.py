"""Table of brush shapes; a new shape is a module with a ``Shape``, and a line here."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from pointbrush.selection.box import BOX
from pointbrush.selection.candidate import OBJECT
from pointbrush.selection.cluster import CLUSTER
from pointbrush.selection.grow import GROW
from pointbrush.selection.lasso import LASSO
from pointbrush.selection.plane import PLANE
from pointbrush.selection.ray import RAY
from pointbrush.selection.shape import Shape
from pointbrush.selection.sphere import SPHERE

SHAPES: Mapping[str, Shape] = MappingProxyType(
    {shape.name: shape for shape in (SPHERE, RAY, LASSO, BOX, GROW, CLUSTER, PLANE, OBJECT)}
)
"""Shapes by name, in the order of the documentation."""
