"""Confidence of `icp` and `color-icp` by residual and overlap, learnt on generated recordings.

Each step starts from the last result, so its own residual and overlap are not informative: a step
also fits well on the wrong surface.  The features are therefore computed from the painted points,
moved by all steps.
"""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.tracking.model.confidence import log_ratio, squashed
from pointbrush.tracking.options.confidence import IcpConfidenceOptions


@dataclass(frozen=True, slots=True)
class IcpEvidence:
    """Features of a step, from which its confidence is computed.

    ``residual``: median distance of the painted points, moved by all steps, from points of the
    frame, in spacings; ``found``: share of the painted points near labelled points; ``beyond``:
    share of labelled points far from painted points, because labels leak to touching surfaces.
    """

    residual: float
    found: float
    beyond: float

    def features(self, options: IcpConfidenceOptions) -> dict[str, float]:
        """Return the features with weights, by name."""
        return {
            # A residual below a spacing is not informative: the same surface is always so near.
            "residual": max(0.0, log_ratio(self.residual, options.max_log_residual)),
            "found": self.found,
            "beyond": self.beyond,
        }

    def likelihood(self, options: IcpConfidenceOptions) -> float:
        """Return the likelihood, 0 to 1, of this step alone."""
        odds = options.weights.odds(self.features(options)) + options.offset
        return squashed(odds)
