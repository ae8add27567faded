"""Registration of a track in a frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pointbrush.tracking.interface import F64, I64


@dataclass(frozen=True, eq=False)
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
    isolated: bool = False
    """The moving points that hang together there are the object and nothing else."""
    growth_refused: bool = False
    """The part that makes it much longer ends all round with it, and may be what holds it."""
    alternatives_failed: bool = False
    """It was looked for elsewhere too, in this frame or before, and that was no better."""
    restarts_motion: bool = False
    """It was found far from where it was predicted: its motion begins here."""
    faint: I64 = field(default_factory=lambda: np.empty(0, np.int64))
    """Points of ``near`` that are hardly before the background."""
    undisputed: float = 1.0
    """Share of what it claimed there that no other object has."""
    confidence_cap: float = 1.0
    """Confidence at most, since it may have changed places with another."""
    neutral: I64 = field(default_factory=lambda: np.empty(0, np.int64))
    """Points near the model that nothing unlabelled explains: other movers of nothing."""
    uncovered: I64 = field(default_factory=lambda: np.empty(0, np.int64))
    """Its points that another label hid a moment ago."""
    border: float = 0.0
    """Share of its points that touch moving points that are no track's; of what has no colours."""
    beside: I64 | None = None
    """Points of other moving objects beside a large one; None where that is not known."""
    owned: I64 = field(default_factory=lambda: np.empty(0, np.int64))
    """Points of ``moving`` that some object has, this or another; of large objects."""
    rim: I64 = field(default_factory=lambda: np.empty(0, np.int64))
    """Its points in this frame of which it learns nothing."""
