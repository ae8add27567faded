"""What was found of a thing in a frame, before anything is learnt of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.fitting.judge import Verdict
from pointbrush.tracking.interface import I64
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.segmentation.assign import Claim
from pointbrush.tracking.sensor.view import View


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """A thing at its ``place`` in a ``view``.

    ``found`` points are on its model, ``grown`` (M,) are new surface beside them; ``verdict`` tells
    how well that explains what the sensor saw.
    """

    view: View
    place: Place
    found: Claim
    grown: I64
    verdict: Verdict

    @property
    def points(self) -> I64:
        """(N,) all that were found, those on the model first."""
        return np.concatenate([self.found.indices, self.grown])
