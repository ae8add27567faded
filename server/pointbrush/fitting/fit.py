"""Fit of one box to the points of an object over frames.

The points of a static object form one surface over all frames: its outline determines the yaw, and
its extent the sides.  A moving object is fitted frame by frame, alternating over sides, path and
yaw.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.fitting.front import front_of, passed
from pointbrush.fitting.moving import fit_moving, start_of
from pointbrush.fitting.observation import Observation, View, views_of
from pointbrush.fitting.options import FitOptions
from pointbrush.fitting.parked import Level, fit_still
from pointbrush.fitting.priors import SizePrior
from pointbrush.fitting.yaw import upright
from pointbrush.geometry.quaternions import quaternion_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FittedPose:
    """Pose in a frame's source coordinates.

    ``centre`` (3,); ``quaternion`` (4,): x, y, z, w of frame<-box; ``confidence``: 0 to 1.
    """

    centre: Floats
    quaternion: Floats
    confidence: float


@dataclass(frozen=True, slots=True, eq=False)
class FittedBox:
    """A fit.

    ``size`` (3,): length, width, height in metres; ``poses``: by frame; ``kind``: the prior used;
    ``moves``: whether the object moved; ``front_known``: whether the forward axis is certain.
    """

    size: Floats
    poses: Mapping[int, FittedPose]
    kind: str
    moves: bool
    front_known: bool


def fit_box(
    observations: Sequence[Observation],
    priors: Sequence[SizePrior],
    options: FitOptions | None = None,
) -> FittedBox:
    """Fit a box of one size to an object; frames with too few points get no pose.

    ``priors``: its possible classes.  Raises BadInputError if all frames have too few points.
    """
    chosen = options or FitOptions()
    if not priors:
        raise BadInputError("priors: expected one or more, got none")
    ordered = sorted(observations, key=lambda each: each.time)
    views, posed = views_of(ordered, chosen)
    if not views:
        raise BadInputError(f"points: expected {chosen.least_points} or more in a frame, got fewer")
    if len(views) == 1:
        return _still_result(views, fit_still(views, priors, chosen), posed=False)
    start = start_of(views, posed, priors, chosen)
    if not start.moves and posed:
        return _still_result(views, fit_still(views, priors, chosen), posed)
    level = fit_moving(start, chosen)
    if not start.moves:
        return _still_result(views, level)
    distance = float(np.linalg.norm(level.centres[-1] - level.centres[0]))
    return _result(views, level, moves=True, known=distance > chosen.headed)


def _still_result(views: list[View], level: Level, posed: bool = False) -> FittedBox:
    """Return a static object's fit turned to its front, known if a posed sensor passed it."""
    if level.prior.person:
        return _result(views, level, moves=False, known=False)
    seen = [
        (view.xyz - centre) @ upright(yaw)
        for view, centre, yaw in zip(views, level.centres, level.yaws, strict=True)
    ]
    front = front_of(np.concatenate(seen), level.size)
    headed = replace(level, yaws=level.yaws + (np.pi if front.direction < 0 else 0.0))
    return _result(views, headed, moves=False, known=posed and front.sure and passed(views))


def _result(views: list[View], level: Level, moves: bool, known: bool) -> FittedBox:
    poses = {}
    for view, centre, yaw, sure in zip(
        views, level.centres, level.yaws, level.confidence, strict=True
    ):
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = upright(yaw), centre
        T_frame_box = np.linalg.inv(view.T_level_frame) @ T
        poses[view.frame] = FittedPose(
            T_frame_box[:3, 3], quaternion_of(T_frame_box[:3, :3]), float(sure)
        )
    return FittedBox(level.size, poses, level.prior.name, moves, known)
