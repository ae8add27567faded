"""Association of tracks and points of a frame: claimed points and additional ones."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pointbrush.tracking.interface import I64, Mask
from pointbrush.tracking.model.registration import Registration, no_points
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Claim, without


@dataclass(frozen=True, slots=True, eq=False)
class Association:
    """The ``registration`` of a track in a frame, and its ``claim`` on points there."""

    registration: Registration
    claim: Claim
    neutral: I64 = field(default_factory=no_points)
    """Unclaimed points near the model that are not evidence for another moving object."""
    restarts_motion: bool = False
    """Whether it was found far from its predictions, so that its motion restarts."""
    undisputed: float = 1.0
    """Share of its claimed points that no other object has."""


@dataclass(frozen=True, slots=True, eq=False)
class Associations:
    """Tracks ``found`` in ``view``, by label.

    ``free`` (N,): mask of points that the run may take, assigned or not; ``background``: model of
    the static scene.
    """

    view: View
    background: Background
    free: Mask
    found: Mapping[int, Association] = field(default_factory=dict)

    @property
    def registrations(self) -> dict[int, Registration]:
        """Registrations by label."""
        return {label: one.registration for label, one in self.found.items()}

    @property
    def claims(self) -> dict[int, Claim]:
        """Claims by label."""
        return {label: one.claim for label, one in self.found.items()}

    def put(self, label: int, association: Association) -> Associations:
        """Return a copy with a track's association added or replaced."""
        return replace(self, found={**self.found, label: association})

    def unclaimed(self, but: Collection[int] = ()) -> Mask:
        """Return a mask (N,) of free points without a claim, ignoring claims of labels ``but``."""
        others = (one.claim for label, one in self.found.items() if label not in but)
        return without(self.free, others)


@dataclass(frozen=True, slots=True, eq=False)
class LabelledPoints:
    """Points of a track in a frame: its ``claim``, and new surface ``grown`` (M,)."""

    claim: Claim
    grown: I64 = field(default_factory=no_points)
    neutral: I64 = field(default_factory=no_points)
    """See ``Association``; includes points that may be another object's."""
    isolated: bool = False
    """Whether the connected moving points there are only this object."""
    end_on: bool = False
    """Whether it was painted end on, and its whole length is now visible."""
    rim: I64 = field(default_factory=no_points)
    """Labelled points of this frame that are excluded from learning."""
    beside: I64 | None = None
    """Points of other moving objects beside a large one; None if unknown."""
    owned: I64 = field(default_factory=no_points)
    """Moving points there of any tracked object, for large objects."""

    @staticmethod
    def of(view: View, association: Association) -> LabelledPoints:
        """Return the claimed points only; for a moving sensor, all near points are ``beside``."""
        beside = association.registration.near if view.roams else None
        return LabelledPoints(association.claim, neutral=association.neutral, beside=beside)

    @property
    def points(self) -> I64:
        """(M,) claimed points, followed by new surface."""
        return np.concatenate([self.claim.indices, self.grown])
