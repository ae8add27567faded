"""How far to trust what somebody has of a frame, among all who are there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.objects.confidence import log_ratio, squashed
from pointbrush.tracking.options import PersonConfidenceOptions, TrackerOptions


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

    def features(self, options: PersonConfidenceOptions) -> list[float]:
        """What the odds are made of."""
        return [
            self.fit,
            self.disputed,
            abs(log_ratio(self.size, options.max_log_size)),
            abs(log_ratio(self.change, options.max_log_change)),
            max(min(self.like, 0.0), options.min_log_clothes),
            float(self.back),
            self.touching,
            self.wider,
            self.astray,
        ]

    def likelihood(self, options: TrackerOptions) -> float:
        """0..1, of this frame by itself."""
        return squashed(
            float(
                np.array(options.person_confidence.weights)
                @ self.features(options=options.person_confidence)
            )
            + options.person_confidence.offset,
            stretch=1.0,
            options=options.confidence,
        )
