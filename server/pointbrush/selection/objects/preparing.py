"""Frame → state: cells, ground, graph, pieces, merge tree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.objects.cells import (
    Cells,
    height_over_floor,
    height_over_ground,
    make_cells,
)
from pointbrush.selection.objects.graph import Graph, across_edges, bridges, make_graph, make_pieces
from pointbrush.selection.objects.options import ObjectOptions
from pointbrush.selection.objects.planes import find_planes
from pointbrush.selection.objects.state import ObjectFrame, ObjectState, Parts, state_of
from pointbrush.selection.objects.sums import Pieces, sum_pieces
from pointbrush.selection.objects.tree import grow_tree
from pointbrush.selection.objects.weights import Weights, built_in

Floats = NDArray[np.float64]

LEVEL_FROM_ROOM = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Rotation from room coordinates, y up, to level ones, z up."""


def prepare(
    frame: ObjectFrame, options: ObjectOptions | None = None, weights: Weights | None = None
) -> ObjectState:
    """Return the state of a frame; weights are those of the package unless others are given.

    Raises BadInputError for a malformed frame.
    """
    parts = part_frame(frame, options or ObjectOptions())
    model = (weights or built_in(frame.sensor)).merge
    tree = grow_tree(parts.pieces, parts.size**2, model)
    return state_of(parts, frame.sensor, tree)


def part_frame(frame: ObjectFrame, options: ObjectOptions) -> Parts:
    """Return a frame's cells and pieces.  Raises BadInputError as ``prepare`` does."""
    frame.check()
    finite = np.isfinite(frame.xyz).all(axis=1)
    every = bool(finite.all())

    def kept(column: NDArray[np.generic] | None) -> NDArray[np.generic] | None:
        return column if every or column is None else column[finite]

    T = np.eye(4) if frame.T_room_local is None else frame.T_room_local
    R = np.eye(3) if frame.T_room_local is None else LEVEL_FROM_ROOM @ T[:3, :3]
    xyz = np.asarray(kept(frame.xyz), np.float64)
    cells = make_cells(
        np.ascontiguousarray(xyz @ R.T),
        kept(frame.rgb),  # type: ignore[arg-type]
        kept(frame.intensity),  # type: ignore[arg-type]
        frame.sensor,
        options.cells,
    )
    of_point = cells.of_point
    if not every:
        of_point = np.full(len(finite), -1, np.int32)
        of_point[finite] = cells.of_point
    viewpoint = None if frame.viewpoint is None else R @ frame.viewpoint
    piece, pieces = _pieces(cells, viewpoint, frame, options)
    place = np.zeros(3) if frame.viewpoint is None else np.array(frame.viewpoint, np.float64)
    plane = np.full((1, len(pieces.sums)), -1)
    if frame.sensor in options.ladder.growing:
        plane = find_planes(pieces, cells.size, options.planes)
    return Parts(of_point, cells.center @ R, cells.size, piece, pieces, place, plane)


def _pieces(
    cells: Cells, viewpoint: Floats | None, frame: ObjectFrame, options: ObjectOptions
) -> tuple[NDArray[np.int64], Pieces]:
    sensor = frame.sensor
    if sensor == "lidar":
        height = height_over_ground(cells.center, options.ground)
    else:
        height = height_over_floor(cells.center)
    graph: Graph = make_graph(cells.center, cells.lab, viewpoint, cells.size, sensor, options.graph)
    piece = make_pieces(graph, height, sensor, options.pieces, options.ground)
    links = bridges(graph, sensor, options.bridges)
    place = np.column_stack([cells.center[:, :2] - _middle(cells.center), height])
    across = across_edges(cells.center, graph.normal, cells.lab, links)
    return piece, sum_pieces(piece, place, cells.lab, graph, links, across)


def _middle(center: Floats) -> Floats:
    """Return the middle (2,) of the plan, so that squares stay small numbers."""
    return center[:, :2].mean(axis=0) if len(center) else np.zeros(2)
