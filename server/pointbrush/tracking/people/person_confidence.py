"""How far to trust what somebody has of a frame, among all who are there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

WEIGHTS = np.array([-0.5, -3.0, -1.2, -0.3, 1.0, -0.5, -5.0, -20.0, -1.4])
OFFSET = 3.0


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
            abs(_log(self.size, 4.0)),
            abs(_log(self.change, 1.0)),
            max(min(self.like, 0.0), -3.0),
            float(self.back),
            self.touching,
            self.wider,
            self.astray,
        ]

    def likelihood(self) -> float:
        """0..1, of this frame by itself."""
        odds = float(WEIGHTS @ self.features()) + OFFSET
        return 1.0 / (1.0 + float(np.exp(np.clip(-odds, -30, 30))))


def _log(ratio: float, most: float) -> float:
    return float(np.clip(np.log(max(ratio, 1e-3)), -most, most))
