"""People and other things that bend: a graph of nodes that move together but not alike."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.grid import cells_of, means_of
from pointbrush.tracking.interface import F32, F64, I64
from pointbrush.tracking.registration import Target

LINKS = 4
ROUNDS = 3


def nodes_of(xyz: F64, apart: float) -> F64:
    """(K, 3) means of the points (M, 3) of each cell of ``apart`` metres."""
    return means_of(xyz, cells_of(xyz, apart))


def warp(place: F64, colour: F32, target: Target, apart: float, scale: float) -> F64:
    """Bend ``place`` (M, 3) onto the target: displacements (M, 3), smooth over the node graph.

    Nodes lie ``apart`` metres from each other; ``scale`` metres is the distance at which a pair
    counts half.  Each round pairs the points in place and colour, averages the displacements at
    the nodes, and smooths them over each node's neighbours.
    """
    nodes = nodes_of(place, apart)
    tree = cKDTree(nodes)
    k = min(LINKS, len(nodes))
    distance, link = tree.query(place, k=np.arange(1, k + 1))
    share = np.exp(-((np.asarray(distance) / apart) ** 2)) + 1e-9
    share /= share.sum(axis=1, keepdims=True)
    link = np.asarray(link, np.int64)
    _, around = tree.query(nodes, k=np.arange(1, min(6, len(nodes)) + 1))
    around = np.asarray(around, np.int64)
    moved = np.zeros((len(nodes), 3))
    offset = np.zeros_like(place)
    for turn in range(ROUNDS):
        s = scale / (1 + 0.5 * turn)
        gap, index = target.nearest(place + offset, colour, 3.0 * s)
        weight = np.where(gap < 3.0 * s, 1.0 / (1.0 + (gap / s) ** 2) ** 2, 0.0)
        pull = target.xyz[index] - place
        moved = _average(link, share * weight[:, None], pull, moved)
        moved = 0.5 * moved + 0.5 * moved[around].mean(axis=1)
        offset = np.einsum("ij,ijk->ik", share, moved[link])
    return offset


def _average(link: I64, weight: F64, pull: F64, before: F64) -> F64:
    """Weighted mean of the points' pulls at each node, leaning on ``before`` where few pull."""
    count = len(before)
    flat, w = link.ravel(), weight.ravel()
    total = np.bincount(flat, weights=w, minlength=count)
    result = np.empty_like(before)
    for axis in range(3):
        each = w * np.repeat(pull[:, axis], link.shape[1])
        result[:, axis] = np.bincount(flat, weights=each, minlength=count)
    lean = 0.5
    return np.asarray((result + lean * before) / (total + lean)[:, None])
