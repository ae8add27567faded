"""The additive octree of a large frame: the points of each node, as arrays, without files.

A node covers a cube and keeps an even subsample of the points that its ancestors left: one point
for each occupied voxel of the cube, at most ``NODE_POINTS``.  The rest goes on to its children,
the octants; a node with few enough points keeps them all.  Every point is kept exactly once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences.octree.order import AXIS_BITS

NODE_POINTS = 65536
"""Most points in a node, which is one chunk."""

BITS = AXIS_BITS
"""Levels below a subtree's cube that its Morton codes resolve."""

_VOXEL_BITS = 7
_KEPT = 32768
_FEW = 8192
"""A child with no more points than this stays with its parent while there is room."""
_HANDED_UP_BITS = 6
_HANDED_UP = 8192
_WHOLLY_UP = 2048

Numbers = NDArray[np.int64]


def sort_codes(codes: Numbers) -> tuple[Numbers, Numbers]:
    """Sorted codes (N,) and the numbers (N,) that sort them, equal codes in given order."""
    room = 63 - 3 * BITS
    if len(codes) >= 1 << room:
        order = np.argsort(codes, kind="stable")
        return codes[order], order
    keys = (codes << room) | np.arange(len(codes))
    keys.sort()
    return keys >> room, keys & ((1 << room) - 1)


def _middles(codes: Numbers, depth: int) -> Numbers:
    """Return the middle position of each run of sorted codes in a voxel ``depth`` levels down."""
    voxel = codes >> (3 * max(BITS - depth, 0))
    start = np.flatnonzero(voxel[1:] != voxel[:-1]) + 1
    start = np.concatenate([[0], start])
    middle: Numbers = (start + np.append(start[1:], len(codes)) - 1) // 2
    return middle


def _thin(numbers: Numbers, most: int) -> Numbers:
    if len(numbers) <= most:
        return numbers
    return numbers[np.arange(most) * len(numbers) // most]


def hand_up(codes: Numbers) -> Numbers:
    """Positions in sorted ``codes`` (N,) of the points that a subtree gives to its ancestors.

    All cubes of one size give the density of one grid, so that the coarse levels are even.
    """
    if len(codes) <= _WHOLLY_UP:
        return np.arange(len(codes))
    return _thin(_middles(codes, _HANDED_UP_BITS), min(_HANDED_UP, len(codes) // 2))


def _keep(codes: Numbers, depth: int) -> Numbers:
    """Positions of the even subsample that a node at ``depth`` keeps of its sorted codes."""
    for finer in range(_VOXEL_BITS, BITS + 1):
        kept = _middles(codes, depth + finer)
        if len(kept) >= _KEPT or depth + finer >= BITS:
            break
    return _thin(kept, _KEPT)


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A node keeps the points at ``positions`` of the sorted codes; ``depth`` in the subtree."""

    depth: int
    parent: int
    positions: Numbers


def build(codes: Numbers, positions: Numbers) -> list[Node]:
    """The nodes over ``positions`` of sorted ``codes``; a parent comes before its children.

    ``parent`` is the number of a node in the result, -1 for the first.
    """
    nodes: list[Node] = []
    todo = [(0, -1, positions)] if len(positions) else []
    while todo:
        todo = [child for entry in todo for child in _split(codes, *entry, nodes)]
    return nodes


def _split(
    codes: Numbers, depth: int, parent: int, positions: Numbers, nodes: list[Node]
) -> list[tuple[int, int, Numbers]]:
    """Add the node over ``positions`` to ``nodes``; return depth, parent and points of children."""
    if len(positions) <= NODE_POINTS:
        nodes.append(Node(depth, parent, positions))
        return []
    mine = codes[positions]
    # A cluster in one small corner: start where it fills its cube.
    depth = max(depth, BITS - (int(mine[0] ^ mine[-1]).bit_length() + 2) // 3)
    if depth >= BITS:
        return _pile(depth, parent, positions, nodes)
    rest = np.ones(len(mine), np.bool_)
    rest[_keep(mine, depth)] = False
    octants = (mine >> (3 * (BITS - depth - 1))) & 7
    counts = np.bincount(octants[rest], minlength=8)
    kept = len(mine) - int(counts.sum())
    children = []
    for octant in range(8):
        if counts[octant] and counts[octant] <= _FEW and kept + counts[octant] <= NODE_POINTS:
            rest &= octants != octant  # too few for a separate chunk
            kept += int(counts[octant])
        elif counts[octant]:
            children.append(octant)
    number = len(nodes)
    nodes.append(Node(depth, parent, positions[~rest]))
    return [(depth + 1, number, positions[rest & (octants == octant)]) for octant in children]


def _pile(
    depth: int, parent: int, positions: Numbers, nodes: list[Node]
) -> list[tuple[int, int, Numbers]]:
    """Divide points at one place, more than a node holds, among as many nodes as needed."""
    nodes.extend(
        Node(depth, parent, positions[start : start + NODE_POINTS])
        for start in range(0, len(positions), NODE_POINTS)
    )
    return []
