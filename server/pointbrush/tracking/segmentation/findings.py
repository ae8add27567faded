"""What is found of all objects in one frame so far; each step of it takes in what it finds."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from pointbrush.tracking.background.depth_background import Background
from pointbrush.tracking.interface import Mask
from pointbrush.tracking.objects.place import Place
from pointbrush.tracking.segmentation.assign import Claim, without
from pointbrush.tracking.sensor.view import View


@dataclass(eq=False)
class Findings:
    """Label → where it is in ``view``, and which points it would have there.

    ``free`` (N,) points that the run may take, whoever of it has them; ``background`` knows what
    stands still.
    """

    view: View
    background: Background
    free: Mask
    places: dict[int, Place] = field(default_factory=dict)
    claims: dict[int, Claim] = field(default_factory=dict)

    def put(self, label: int, place: Place, claim: Claim) -> None:
        """A thing was found, or found elsewhere."""
        self.places[label], self.claims[label] = place, claim

    def unclaimed(self, but: Collection[int] = ()) -> Mask:
        """(N,) free points that nobody claims, ``but`` for some labels."""
        others = (claim for label, claim in self.claims.items() if label not in but)
        return without(self.free, others)
