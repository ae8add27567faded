"""How far to trust what somebody has of a frame, among all who are there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.objects.confidence import log_ratio, squashed

WEIGHTS, OFFSET = np.array([-0.5, -3.0, -1.2, -0.3, 1.0, -0.5, -5.0, -20.0, -1.4]), 3.0
"""Of the log odds: a weight for each of the ``features``, set by hand, and what is added."""
SIZE_MOST, CHANGE_MOST, LIKE_LEAST = 4.0, 1.0, -3.0
"""Logarithms at most of the size and of a sudden change of it, and at least of how like the clothes
are: beyond, they say no more."""


@dataclass(frozen=True, slots=True)
class PersonEvidence:
    """``fit`` mean cost of the cells; ``disputed`` share that are hardly less another's; ``size``
    and ``change`` number of cells over the most and over the last; ``shown`` share of the surface
    that nothing hides; ``like`` how like the clothes, a mean logarithm over the usual; ``back``
    whether nothing was seen in the frame before; ``touching`` share of the cells that touch
    another's, since a border through a body may be anywhere; ``wider`` metres by which they are
    spread along the ground more than one person is, since they may be those of two; ``astray`` how
    much farther they are from where he was expected than from where another was, a logarithm.
    """

    fit: float
    disputed: float
    size: float
    change: float
    shown: float
    like: float
    back: bool
    touching: float
    wider: float
    astray: float

    def features(self) -> list[float]:
        """What the odds are made of."""
        return [
            self.fit,
            self.disputed,
            abs(log_ratio(self.size, SIZE_MOST)),
            abs(log_ratio(self.change, CHANGE_MOST)),
            max(min(self.like, 0.0), LIKE_LEAST),
            float(self.back),
            self.touching,
            self.wider,
            self.astray,
        ]

    def likelihood(self) -> float:
        """0..1, of this frame by itself."""
        return squashed(float(WEIGHTS @ self.features()) + OFFSET, stretch=1.0)
