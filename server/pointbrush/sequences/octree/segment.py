"""Encoding one cube of a large frame: its rows → nodes in stored order, ready to be written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences import blocks
from pointbrush.sequences.columns import POINT_FIELDS, gather, to_local
from pointbrush.sequences.octree.coordinates import pack_coordinates
from pointbrush.sequences.octree.nodes import Node, build, hand_up, sort_codes
from pointbrush.sequences.octree.order import morton_codes
from pointbrush.sequences.octree.packed import Packed
from pointbrush.sequences.octree.rows import Rows
from pointbrush.sequences.wire.chunk import Grid, encode_chunks, wire_colors


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """Nodes of one cube.  Points, blocks, bytes and parents count from the segment's start.

    ``up`` are the rows that the ancestors keep instead.
    """

    columns: dict[str, NDArray[Any]]
    packed: Packed
    chunks: NDArray[Any]
    wire: bytes
    block_first: NDArray[np.int64]
    block_lo: NDArray[np.float32]
    block_hi: NDArray[np.float32]
    blocks_per_chunk: NDArray[np.int64]
    error: float
    up: Rows

    def __len__(self) -> int:
        return len(self.columns["source_index"])


def encode_cube(
    rows: Rows,
    corner: NDArray[np.float64],
    edge: float,
    level: int,
    grid: Grid,
    scaling: NDArray[np.float64],
    *,
    hands_up: bool,
) -> Segment:
    """The subtree over ``rows`` in the cube at ``corner`` (local), ``level`` below the root.

    ``scaling`` (3, 3) is that of ``scaling_of``.
    """
    local = to_local(rows["xyz"], grid.shift)
    codes, order = sort_codes(morton_codes(local, corner, edge))
    keep = np.ones(len(rows), np.bool_)
    if hands_up:
        keep[hand_up(codes)] = False
    nodes = build(codes, np.flatnonzero(keep))
    nodes, parents = _breadth_first(nodes)
    counts = [len(node.positions) for node in nodes]
    tree = _Tree(counts, [level + node.depth for node in nodes], parents)
    stored = order[np.concatenate([np.empty(0, np.int64), *(node.positions for node in nodes)])]
    up = gather(rows, order[~keep])
    return _encode(rows, local.take(stored, axis=0), stored, tree, grid, scaling, up)


def _breadth_first(nodes: list[Node]) -> tuple[list[Node], list[int]]:
    order = sorted(range(len(nodes)), key=lambda number: nodes[number].depth)
    place = {number: at for at, number in enumerate(order)} | {-1: -1}
    return [nodes[number] for number in order], [place[nodes[n].parent] for n in order]


class _Tree(NamedTuple):
    """Number of points, level and parent of each node, breadth first."""

    counts: list[int]
    level: list[int]
    parent: list[int]


def _encode(
    rows: Rows,
    xyz: NDArray[np.float32],
    stored: NDArray[np.int64],
    tree: _Tree,
    grid: Grid,
    scaling: NDArray[np.float64],
    up: Rows,
) -> Segment:
    names = rows.dtype.names or ()
    colors = wire_colors(
        rows["rgb"] if "rgb" in names else None,
        rows["intensity"] if "intensity" in names else None,
        grid.intensity_range,
        len(rows),
    ).take(stored, axis=0)
    first = np.concatenate([[0], np.cumsum(tree.counts)]).astype(np.int64)
    chunks = encode_chunks(xyz, colors, first, grid)
    chunks.table["level"] = tree.level
    chunks.table["parent"] = tree.parent
    if chunks.order is not None:
        stored, xyz = stored.take(chunks.order), xyz.take(chunks.order, axis=0)
    rows = gather(rows, stored)
    block_first, of_chunk = blocks.cut(first)
    lo, hi = blocks.bound(xyz, block_first)
    return Segment(
        {
            name: np.ascontiguousarray(rows[name])
            for name in ("source_index", *POINT_FIELDS)
            if name in names
        },
        pack_coordinates(rows["xyz"], scaling, block_first),
        chunks.table,
        chunks.wire,
        block_first[:-1],
        lo,
        hi,
        np.diff(of_chunk),
        chunks.error,
        up,
    )
