"""Confidence of `icp` and `color-icp` by residual and overlap, learnt on generated recordings.

The methods go on from whatever they found, so that the residual and the overlap of a step tell
nothing: it fits well on the wrong surface too.  Those of what was painted do, moved by all steps.
"""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.tracking.model.confidence import log_ratio, squashed
from pointbrush.tracking.options.confidence import IcpConfidenceOptions


@dataclass(frozen=True, slots=True)
class IcpEvidence:
    """Features of a step, from which its confidence is computed.

    ``residual`` median distance of the painted points, moved by all steps, from those of the
    frame, in spacings; ``found`` share of them that lie on points that were found, and ``beyond``
    share of what was found that lies on none of them: labels grow over what they touch.
    """

    residual: float
    found: float
    beyond: float

    def features(self, options: IcpConfidenceOptions) -> dict[str, float]:
        """Compute the features that have weights, by name."""
        return {
            # Less than a spacing says nothing: so near is all surface that is seen again.
            "residual": max(0.0, log_ratio(self.residual, options.max_log_residual)),
            "found": self.found,
            "beyond": self.beyond,
        }

    def likelihood(self, options: IcpConfidenceOptions) -> float:
        """0..1, of this step by itself."""
        odds = options.weights.odds(self.features(options)) + options.offset
        return squashed(odds)
