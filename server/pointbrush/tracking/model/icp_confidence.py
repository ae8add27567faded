"""Confidence of `icp` and `color-icp` by residual and overlap, learnt on generated recordings.

The methods go on from whatever they found, so that the residual and the overlap of a step tell
nothing: it fits well on the wrong surface too.  Those of what was painted do, moved by all steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.model.confidence import log_ratio
from pointbrush.tracking.options import IcpConfidenceOptions


@dataclass(frozen=True, slots=True)
class IcpEvidence:
    """Features of a step, from which its confidence is computed.

    ``kept`` share of the painted points, moved by all steps, that lie on points of the frame, and
    ``residual`` median distance of them from those, in spacings; ``size`` number of points over
    that painted.
    """

    kept: float
    residual: float
    size: float

    def features(self, options: IcpConfidenceOptions) -> dict[str, float]:
        """Compute the features that have weights, by name."""
        return {
            "kept": self.kept,
            "residual": log_ratio(self.residual, options.max_log_residual),
            "size": abs(log_ratio(self.size, options.max_log_size)),
        }

    def likelihood(self, options: IcpConfidenceOptions) -> float:
        """0..1, of this step by itself."""
        odds = options.weights.odds(self.features(options)) + options.offset
        return float(1.0 / (1.0 + np.exp(-np.clip(odds, -options.max_odds, options.max_odds))))
