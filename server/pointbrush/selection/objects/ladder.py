"""The few levels that are offered, from part to group."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pointbrush.selection.objects.options import LadderOptions

Mask = NDArray[np.bool_]


def choose_levels(
    masks: Mask,
    size: NDArray[np.float64],
    score: NDArray[np.float64],
    kept: int | None,
    options: LadderOptions,
) -> list[int]:
    """Return numbers of nested candidates: the one to show, then the others by falling score.

    ``masks`` (n, P) pieces, ``size`` (n,) their cells, ``score`` (n,); ``kept`` the number of
    what was taken before, which stays among them, and first unless another is clearly better.
    """
    chosen = [] if kept is None else [kept]
    closest = options.closest if kept is None else options.closest_after
    for i in np.argsort(-score, kind="stable").tolist():
        if len(chosen) == options.levels:
            break
        if all(_apart(masks, size, i, other, closest) for other in chosen):
            chosen.append(i)
    if kept is None or len(chosen) == 1:
        return chosen
    better = score[chosen[1]] > score[kept] + options.keep
    return [chosen[1], kept, *chosen[2:]] if better else chosen


def _apart(masks: Mask, size: NDArray[np.float64], i: int, other: int, closest: float) -> bool:
    """Whether one of two candidates holds the other and is clearly larger."""
    small, large = (i, other) if size[i] < size[other] else (other, i)
    if size[small] > closest * size[large]:
        return False
    return not bool((masks[small] & ~masks[large]).any())
