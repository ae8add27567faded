"""Registration of a track in a frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pointbrush.tracking.interface import F64, I64


def no_points() -> I64:
    """Return an empty array of point numbers."""
    return np.empty(0, np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """Registered ``pose`` (4, 4) of a track, and its model's points ``world`` (M, 3).

    Indices of the frame's points: ``around``, inside the searched ``box``; ``near``, available to
    it; ``moving``, in front of the background.  ``cost``: cost of the fit, 0 to 1.
    """

    pose: F64
    world: F64
    box: tuple[F64, F64]
    around: I64
    near: I64
    moving: I64
    cost: float
    predicted: F64 = field(default_factory=lambda: np.empty((0, 4, 4)))
    """(K, 4, 4) predicted poses."""
    tried: F64 = field(default_factory=lambda: np.empty((0, 4, 4)))
    """(H, 4, 4) registered hypotheses, with ``costs``."""
    costs: F64 = field(default_factory=lambda: np.empty(0))
    """(H,) cost of each hypothesis."""
    alternatives_failed: bool = False
    """Whether a search elsewhere, in this or an earlier frame, found no better pose."""
    faint: I64 = field(default_factory=no_points)
    """Points of ``near`` that are barely in front of the background."""
