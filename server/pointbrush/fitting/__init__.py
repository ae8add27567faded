"""Boxes fitted to a label's points over frames, with a prior of the class's size.

fit = fit_box(observations, priors_of("car"))
"""

from __future__ import annotations

from pointbrush.fitting.fit import FittedBox, FittedPose, fit_box
from pointbrush.fitting.observation import Observation, near_rays
from pointbrush.fitting.options import FitOptions
from pointbrush.fitting.priors import BUILT_IN, SizePrior, priors_of

__all__ = [
    "BUILT_IN",
    "FitOptions",
    "FittedBox",
    "FittedPose",
    "Observation",
    "SizePrior",
    "fit_box",
    "near_rays",
    "priors_of",
]
