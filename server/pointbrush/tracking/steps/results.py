"""Results of the steps of a frame, one after the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pointbrush.tracking.interface import I64, Mask
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.permissions import FrameRules
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Associations, LabelledPoints
from pointbrush.tracking.steps.settle import Outcome


@dataclass(frozen=True, eq=False)
class FrameTask:
    """A frame to track into: ``fixed`` points of labels are known, those of labels ``aside`` too,
    which are not followed; ``free`` (N,) may be taken by the tracks that are ``sought``."""

    view: View
    rules: FrameRules
    fixed: dict[int, I64]
    aside: dict[int, I64]
    free: Mask
    sought: list[Track]


@dataclass(frozen=True, eq=False)
class FrameAssociations:
    """``associations`` of tracks in a frame; label → confidence at most in ``caps``, and moving
    points (M,) among which a large track that is not found may be ``hidden``."""

    associations: Associations
    caps: Mapping[int, float]
    hidden: Mapping[int, I64]


@dataclass(frozen=True, eq=False)
class FrameClaims:
    """Points that tracks are given, ``labelled``, and those of large ones that have ``emerged``
    from hiding, so changed that they are learnt anew; by label."""

    labelled: Mapping[int, LabelledPoints]
    emerged: Mapping[int, I64]


@dataclass(frozen=True, eq=False)
class FrameOutcomes:
    """Outcome of the tracks that were ``settled``, and points of those ``emerged``."""

    settled: Mapping[int, Outcome]
    emerged: Mapping[int, I64]
