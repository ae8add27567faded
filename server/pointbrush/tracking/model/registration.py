"""Registration of a track in a frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pointbrush.tracking.interface import F64, I64


def no_points() -> I64:
    """An empty array of point numbers."""
    return np.empty(0, np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """Registered ``pose`` (4, 4) of a track, and its model's points ``world`` (M, 3).

    Of the frame's points: those ``around``, in a ``box`` that was searched; ``near``, that it may
    have; ``moving``, before the background.  ``cost`` of the fit, 0 to 1.
    """

    pose: F64
    world: F64
    box: tuple[F64, F64]
    around: I64
    near: I64
    moving: I64
    cost: float
    predicted: F64 = field(default_factory=lambda: np.empty((0, 4, 4)))
    """(K, 4, 4) where it was expected."""
    tried: F64 = field(default_factory=lambda: np.empty((0, 4, 4)))
    """(H, 4, 4) poses that it was registered to, with ``costs``."""
    costs: F64 = field(default_factory=lambda: np.empty(0))
    """(H,) what each of them cost."""
    alternatives_failed: bool = False
    """It was looked for elsewhere too, in this frame or before, and that was no better."""
    faint: I64 = field(default_factory=no_points)
    """Points of ``near`` that are hardly before the background."""
