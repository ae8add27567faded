"""Which of several each cell of a surface belongs to, where cells that touch mostly agree.

Source: the mean field of a Potts model, swept over the cells in turns, as in Krähenbühl and Koltun
2011, but with neighbours that touch in place of a dense filter.
"""

from __future__ import annotations

import numpy as np

from pointbrush.compiled import compiled
from pointbrush.tracking.geometry.paths import Paths
from pointbrush.tracking.interface import F64


@compiled
def agreed(
    cost: F64,
    links: Paths,
    sweeps: int,
    settled_change: float,
    same_change: float,
    neighbour_weight: float,
    full_neighbours: float,
) -> F64:
    """(N, K) probability that a cell is of each of the K, which ``cost`` it (N, K).

    ``links`` lead from each cell to its neighbours; their length is how much a neighbour counts.
    """
    count, many = cost.shape
    share, now = np.empty((count, many)), np.empty(many)
    asked, moved = np.zeros(count, np.int64), np.zeros(count, np.int64)
    for i in range(count):
        _normalised(-cost[i], share[i])
    for sweep in range(sweeps):
        change = 0.0
        for turn in range(count):
            i = turn if sweep % 2 == 0 else count - 1 - turn
            newest = 0
            for n in range(links.start[i], links.start[i + 1]):
                newest = max(newest, moved[links.end[n]])
            if sweep > 0 and newest < asked[i]:
                continue
            now[:] = 0.0
            total = 0.0
            for n in range(links.start[i], links.start[i + 1]):
                total += links.length[n]
                for k in range(many):
                    now[k] += links.length[n] * share[links.end[n], k]
            scale = (
                neighbour_weight * min(1.0, total / full_neighbours) / total if total > 0.0 else 0.0
            )
            for k in range(many):
                now[k] = scale * now[k] - cost[i, k]
            _normalised(now, now)
            away = 0.0
            for k in range(many):
                away = max(away, abs(now[k] - share[i, k]))
                share[i, k] = now[k]
            change = max(change, away)
            asked[i] = sweep * count + turn + 1
            if away > same_change:
                moved[i] = asked[i]
        if change < settled_change:
            break
    return share


@compiled
def _normalised(odds: F64, out: F64) -> None:
    """Probabilities (K,) of logarithmic ``odds`` (K,)."""
    most, total = odds.max(), 0.0
    for k in range(len(odds)):
        out[k] = np.exp(odds[k] - most)
        total += out[k]
    for k in range(len(odds)):
        out[k] /= total
