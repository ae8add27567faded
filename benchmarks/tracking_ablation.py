"""`auto` with one of its ideas taken out."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any
from unittest.mock import patch

import numpy as np


def _claimed_only(
    _things: object,
    _view: object,
    _places: object,
    claims: dict[int, Any],
    free: Any,
    _scene: object,
) -> tuple[dict[int, Any], Any]:
    taken = ~free
    for claim in claims.values():
        taken[claim.indices] = True
    return {}, taken


IDEAS: dict[str, tuple[str, Any]] = {
    "motion": (
        "pointbrush.tracking.objects.motion.Motion.predictions",
        lambda self: self.poses[-1][None],
    ),
    "background": (
        "pointbrush.tracking.background.depth_background.ImageBackground.static",
        lambda _s, _v, i: (np.zeros(len(i), bool), np.zeros(len(i), bool)),
    ),
    "sharing out": ("pointbrush.tracking.auto.share_out", lambda _s: None),
    "other guesses": ("pointbrush.tracking.fitting.fit.proposals", lambda *_: []),
    "growing": ("pointbrush.tracking.auto.grow", _claimed_only),
    "model over frames": ("pointbrush.tracking.objects.model.Model.gather", lambda *_, **__: None),
    "rivals": (
        "pointbrush.tracking.segmentation.belong.contested",
        lambda _v, found, *_: np.zeros(len(found.indices), bool),
    ),
    "places looked through": (
        "pointbrush.tracking.segmentation.belong.carved",
        lambda _glimpses, _view, _pose, points, _unit: np.zeros(len(points), bool),
    ),
    "missed pieces": (
        "pointbrush.tracking.segmentation.belong.lost_pieces",
        lambda *_: np.empty(0, np.int64),
    ),
    "way of the sensor": ("pointbrush.tracking.sensor.ego_motion.stands", lambda *_: True),
    "ground": (
        "pointbrush.tracking.sensor.view.on_ground",
        lambda xyz: np.zeros(len(xyz), bool),
    ),
    "hidden from a lidar": ("pointbrush.tracking.sensor.view.range_image_of", lambda *_: None),
    "rings": ("pointbrush.tracking.objects.thing.across_rings", lambda _xyz: 0.0),
    "bending": ("pointbrush.tracking.update.learn.strained", lambda *_: 0.0),
    "slow-only keeping": ("pointbrush.tracking.auto.Run._shadow", lambda *_: np.empty((0, 3))),
}
"""Idea -> where it lives, and what does nothing in its place."""


def without(idea: str) -> AbstractContextManager[Any]:
    """A context in which ``auto`` goes without an idea."""
    where, nothing = IDEAS[idea]
    return patch(where, nothing)
