"""A frame's k-d tree: built by a compiled loop on first use, searched by SciPy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.octree.order import bounds

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

LEAF_POINTS = 32

_NODE = np.dtype(
    [
        ("axis", "<i8"),
        ("count", "<i8"),
        ("split", "<f8"),
        ("first", "<i8"),
        ("stop", "<i8"),
        ("addresses", "<i8", 2),
        ("below", "<i8"),
        ("above", "<i8"),
    ]
)
"""A node as SciPy keeps it; it fills in the addresses itself."""


def build(xyz: NDArray[np.float32]) -> cKDTree[None]:
    """Return the tree over points (N, 3), in a third of SciPy's time and without the GIL."""
    from scipy.spatial import cKDTree

    if len(xyz) == 0:
        return cKDTree(xyz, leafsize=LEAF_POINTS)
    from pointbrush.sequences.loops import split_points

    table, splits, numbers = split_points(np.ascontiguousarray(xyz), LEAF_POINTS)
    nodes = np.zeros(len(table), _NODE)
    for column, name in enumerate(("axis", "first", "stop", "below", "above")):
        nodes[name] = table[:, column]
    nodes["count"], nodes["split"] = nodes["stop"] - nodes["first"], splits
    lo, hi = (bound.astype(np.float64) for bound in bounds(xyz))
    data = xyz.astype(np.float64)
    state = (nodes.view("S1"), data, len(data), 3, LEAF_POINTS, hi, lo, numbers, None, None)
    tree: Any = cKDTree.__new__(cKDTree)
    try:
        tree.__setstate__(state)
    except (TypeError, ValueError):  # a SciPy with another layout of nodes
        return cKDTree(xyz, leafsize=LEAF_POINTS, balanced_tree=False)
    built: cKDTree[None] = tree
    return built
