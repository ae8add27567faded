"""Tracks and points of a frame: which points each track claims, and which it gets beside them."""

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
    """Points near the model that nothing unlabelled explains: other movers of nothing."""
    restarts_motion: bool = False
    """It was found far from where it was predicted: its motion begins here."""
    undisputed: float = 1.0
    """Share of what it claimed there that no other object has."""


@dataclass(frozen=True, slots=True, eq=False)
class Associations:
    """Tracks ``found`` in ``view``, by label.

    ``free`` (N,) points that the run may take, whoever of it has them; ``background`` knows what
    stands still.
    """

    view: View
    background: Background
    free: Mask
    found: Mapping[int, Association] = field(default_factory=dict)

    @property
    def registrations(self) -> dict[int, Registration]:
        """Label → registration."""
        return {label: one.registration for label, one in self.found.items()}

    @property
    def claims(self) -> dict[int, Claim]:
        """Label → claim."""
        return {label: one.claim for label, one in self.found.items()}

    def put(self, label: int, association: Association) -> Associations:
        """The same, with a track that was found, or found elsewhere."""
        return replace(self, found={**self.found, label: association})

    def unclaimed(self, but: Collection[int] = ()) -> Mask:
        """(N,) free points that no one claims, ``but`` for some labels."""
        others = (one.claim for label, one in self.found.items() if label not in but)
        return without(self.free, others)


@dataclass(frozen=True, slots=True, eq=False)
class LabelledPoints:
    """Points that a track gets in a frame: its ``claim``, and new surface ``grown`` (M,)."""

    claim: Claim
    grown: I64 = field(default_factory=no_points)
    neutral: I64 = field(default_factory=no_points)
    """See ``Association``; also what may be another's."""
    isolated: bool = False
    """The moving points that hang together there are the object and nothing else."""
    end_on: bool = False
    """An end of it was painted, and now all of its length shows."""
    rim: I64 = field(default_factory=no_points)
    """Its points in this frame of which it learns nothing."""
    beside: I64 | None = None
    """Points of other moving objects beside a large one; None where that is not known."""
    owned: I64 = field(default_factory=no_points)
    """Moving points there that some object has, this or another; of large objects."""

    @staticmethod
    def of(view: View, association: Association) -> LabelledPoints:
        """The claimed points alone; before a sensor that moves all that is near is beside them."""
        beside = association.registration.near if view.roams else None
        return LabelledPoints(association.claim, neutral=association.neutral, beside=beside)

    @property
    def points(self) -> I64:
        """(M,) the claimed ones first."""
        return np.concatenate([self.claim.indices, self.grown])
