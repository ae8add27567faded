"""Which people of a run are followed together, and how each of them fares in a frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pointbrush.tracking.background.depth_background import Background, PictureBackground
from pointbrush.tracking.interface import I64, Mask, TrackState
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.people.group import Group
from pointbrush.tracking.sensor.view import View


class JointTracking:
    """The people among the ``things`` of a run, before a depth camera at rest or a charted scene.

    Nobody is followed so where they hold what is tracked too: it and their hands are told apart by
    one claim; nor where points too far apart to be limbs are a label.
    """

    def __init__(
        self, things: Mapping[int, Thing], options: TrackerOptions, *, continue_lost: bool
    ) -> None:
        """``things`` are all of the run at any time; see ``TrackOptions.continue_lost``."""
        self._things, self._continue_lost, self.options = things, continue_lost, options
        self.group: Group | None = None

    def __contains__(self, label: int) -> bool:
        """Whether a label is followed together with others."""
        return self.group is not None and label in self.group.labels

    def gather(self, view: View, background: Background, labels: Iterable[int]) -> None:
        """Begin with those of the ``labels`` of a frame that are people, where they can be."""
        bodies = {n: self._things[n] for n in labels if self._things[n].body}
        alone = all(
            thing.body and thing.unit < self.options.body.limb_m for thing in self._things.values()
        )
        if bodies and alone and isinstance(background, PictureBackground):
            self.group = Group.of(view, bodies, background)

    def join(self, view: View, background: Background, label: int) -> None:
        """Somebody who was painted in the middle of a run is followed among the others."""
        if self.group is None:
            self.gather(view, background, [label])
        elif self._things[label].body:
            self.group.put(view, label, self._things[label])

    def step(
        self, view: View, background: Background, free: Mask, painted: Mapping[int, I64]
    ) -> dict[int, tuple[TrackState, I64]]:
        """Label → how people fared in the next frame, but for ``painted`` ones, and their points.

        ``free`` (N,) are the points that they may have.
        """
        if self.group is None or not isinstance(background, PictureBackground):
            return {}
        found = self.group.step(view, background, free)
        for label, (track, _) in found.items():
            thing = self._things[label]
            thing.stopped = track.state == "lost" and not self._continue_lost
            if thing.stopped:
                self.group.drop(label)
        return {label: each for label, each in found.items() if label not in painted}
