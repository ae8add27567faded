"""Encoding one cube of a large frame: its rows → nodes in stored order, ready to be written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.sequences import blocks
from pointbrush.sequences.chunk import CHUNK, Grid, encode_chunk, wire_colors
from pointbrush.sequences.columns import POINT_FIELDS, gather, residual, to_local
from pointbrush.sequences.octree import Node, build, hand_up, sort_codes
from pointbrush.sequences.order import morton_codes
from pointbrush.sequences.rows import Rows


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """Nodes of one cube.  Points, blocks, bytes and parents count from the segment's start.

    ``up`` are the rows that go to the ancestors instead.
    """

    columns: dict[str, NDArray[Any]]
    chunks: NDArray[Any]
    wire: bytes
    block_first: NDArray[np.int64]
    block_lo: NDArray[np.float32]
    block_hi: NDArray[np.float32]
    blocks_per_chunk: NDArray[np.int64]
    error: float
    up: Rows

    def __len__(self) -> int:
        return len(self.columns["xyz"])


def encode_cube(
    rows: Rows,
    corner: NDArray[np.float64],
    edge: float,
    level: int,
    grid: Grid,
    *,
    hands_up: bool,
) -> Segment:
    """The subtree over ``rows`` in the cube at ``corner`` (local), ``level`` below the root."""
    local = to_local(rows["xyz"], grid.shift)
    codes, order = sort_codes(morton_codes(local, corner, edge))
    keep = np.ones(len(rows), np.bool_)
    if hands_up:
        keep[hand_up(codes)] = False
    nodes = build(codes, np.flatnonzero(keep))
    nodes, parents = _breadth_first(nodes)
    stored = order[np.concatenate([np.empty(0, np.int64), *(node.positions for node in nodes)])]
    return _encode(
        gather(rows, stored),
        local.take(stored, axis=0),
        nodes,
        parents,
        level,
        grid,
        gather(rows, order[~keep]),
    )


def _breadth_first(nodes: list[Node]) -> tuple[list[Node], list[int]]:
    order = sorted(range(len(nodes)), key=lambda number: nodes[number].depth)
    place = {number: at for at, number in enumerate(order)} | {-1: -1}
    return [nodes[number] for number in order], [place[nodes[n].parent] for n in order]


def _encode(
    rows: Rows,
    xyz: NDArray[np.float32],
    nodes: list[Node],
    parents: list[int],
    level: int,
    grid: Grid,
    up: Rows,
) -> Segment:
    names = rows.dtype.names or ()
    colors = wire_colors(
        rows["rgb"] if "rgb" in names else None,
        rows["intensity"] if "intensity" in names else None,
        grid.intensity_range,
        len(xyz),
    )
    counts = [len(node.positions) for node in nodes]
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    chunks = np.zeros(len(nodes), CHUNK)
    parts: list[bytes] = []
    offset, error = 0, 0.0
    for number, node in enumerate(nodes):
        run = slice(first[number], first[number + 1])
        chunk = encode_chunk(xyz[run], colors[run], grid, hurry=True)
        if chunk.order is not None:
            rows[run], xyz[run] = gather(rows[run], chunk.order), xyz[run][chunk.order]
        chunks[number] = chunk.row
        chunks[number]["level"], chunks[number]["parent"] = level + node.depth, parents[number]
        chunks[number]["first"], chunks[number]["offset"] = first[number], offset
        parts.append(chunk.data)
        offset += len(chunk.data)
        error = max(error, chunk.error)
    columns: dict[str, NDArray[Any]] = {
        name: np.ascontiguousarray(rows[name])
        for name in ("source_index", *POINT_FIELDS)
        if name in names
    }
    exact = residual(rows["xyz"], xyz, grid.shift)
    if exact is not None:
        # One width from the start where it is likely: widening a column later copies all of it.
        wide = rows["xyz"].dtype == np.float64 and exact.dtype.itemsize < 4
        columns["residual"] = exact.astype(np.int32) if wide else exact
    block_first, of_chunk = blocks.cut(first)
    lo, hi = blocks.bound(xyz, block_first)
    return Segment(
        {"xyz": xyz, **columns},
        chunks,
        b"".join(parts),
        block_first[:-1],
        lo,
        hi,
        np.diff(of_chunk),
        error,
        up,
    )
