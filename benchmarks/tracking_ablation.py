"""`auto` with one of its ideas taken out."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any
from unittest.mock import patch

import numpy as np

IDEAS: dict[str, tuple[str, Any]] = {
    "motion": ("pointbrush.tracking.motion.Motion.predictions", lambda self: [self.poses[-1]]),
    "background": (
        "pointbrush.tracking.background.ImageBackground.static",
        lambda _s, _v, i: (np.zeros(len(i), bool), np.zeros(len(i), bool)),
    ),
    "sharing out": ("pointbrush.tracking.auto.share_out", lambda _s: None),
    "other guesses": ("pointbrush.tracking.locate.proposals", lambda *_: []),
    "growing": ("pointbrush.tracking.auto.grow", lambda *_: {}),
    "model over frames": ("pointbrush.tracking.model.Model.gather", lambda *_: None),
    "rivals": (
        "pointbrush.tracking.belong.contested",
        lambda _v, found, *_: np.zeros(len(found.indices), bool),
    ),
    "places looked through": (
        "pointbrush.tracking.belong.carved",
        lambda _glimpses, _view, _pose, points, _unit: np.zeros(len(points), bool),
    ),
    "slow-only keeping": ("pointbrush.tracking.auto.Run._shadow", lambda *_: np.empty((0, 3))),
}
"""Idea -> where it lives, and what does nothing in its place."""


def without(idea: str) -> AbstractContextManager[Any]:
    """A context in which ``auto`` goes without an idea."""
    where, nothing = IDEAS[idea]
    return patch(where, nothing)
