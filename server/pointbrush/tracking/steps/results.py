"""Results of the steps of a frame."""

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
    """A frame to track into.

    ``fixed``: known points by label; ``aside``: known points by label of companions that are not
    tracked; ``free`` (N,): mask of points available to the tracks ``sought``.
    """

    view: View
    rules: FrameRules
    fixed: dict[int, I64]
    aside: dict[int, I64]
    free: Mask
    sought: list[Track]


@dataclass(frozen=True, eq=False)
class FrameAssociations:
    """``associations`` of tracks in a frame.

    ``caps``: maximum confidence by label; ``hidden``: moving points (M,), by label, among which a
    large track that was not found may be.
    """

    associations: Associations
    caps: Mapping[int, float]
    hidden: Mapping[int, I64]


@dataclass(frozen=True, eq=False)
class FrameClaims:
    """Points of tracks by label.

    ``labelled``: assigned points; ``emerged``: points of large tracks that reappeared too changed
    to be registered, and are learnt from scratch.
    """

    labelled: Mapping[int, LabelledPoints]
    emerged: Mapping[int, I64]


@dataclass(frozen=True, eq=False)
class FrameOutcomes:
    """Outcomes of ``settled`` tracks, and points of ``emerged`` ones, by label."""

    settled: Mapping[int, Outcome]
    emerged: Mapping[int, I64]
