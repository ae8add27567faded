"""Fixed-lag smoothing of uncertain frames by tracking backward from a later confident frame.

A frame with an uncertain small object is held back for a few frames.  After a confident detection
the object is tracked backward from there with the updated model, and each frame keeps the result
with the higher confidence.  Source: two-filter smoothing, Fraser and Potter 1969, "The optimum
linear smoother as a combination of two optimum linear filters"; here each frame has one of the two.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np

from pointbrush.tracking.interface import I64, FrameResult, Mask, TrackOptions, TrackState
from pointbrush.tracking.model.motion import Motion
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options.tracks import SmoothingOptions
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Associations
from pointbrush.tracking.steps.claim import together
from pointbrush.tracking.steps.context import set_other_movers
from pointbrush.tracking.steps.grow import grow
from pointbrush.tracking.steps.predict import crop
from pointbrush.tracking.steps.relocate import find_astray, register_and_claim
from pointbrush.tracking.steps.settle import Outcome, settle


@dataclass(frozen=True, eq=False)
class Held:
    """The held-back ``result`` of a frame.

    ``free`` (N,): mask of points that the run may take; ``confidence_caps``: maximum confidence, by
    label, of objects that may have been exchanged; ``done``: labels already smoothed.
    """

    view: View
    free: Mask
    result: FrameResult
    confidence_caps: Mapping[int, float]
    done: frozenset[int] = frozenset()

    def sure(self, label: int) -> bool:
        """Return whether an object was found with confidence."""
        return _confidence(self.result.tracks.get(label)) >= self.view.options.smoothing.sure

    def open(self, label: int) -> bool:
        """Return whether an object is uncertain and not smoothed yet."""
        return label in self.result.tracks and label not in self.done and not self.sure(label)

    def improve(self, label: int, state: TrackState, points: I64) -> Held:
        """Return a copy with the state and points (M,) of an object replaced, if more confident."""
        done, result = self.done | {label}, self.result
        if _confidence(state) <= _confidence(result.tracks.get(label)):
            return replace(self, done=done)
        before = result.assignments.get(label, points[:0])
        points = together(points, before[~self.free[before]])  # painted points stay
        result = replace(
            result,
            assignments={**result.assignments, label: points},
            tracks={**result.tracks, label: replace(state, points=len(points))},
        )
        return replace(self, result=result, done=done)


class Smoother:
    """Last frames of a run, starting with the first one with an uncertain small object."""

    def __init__(self, track_options: TrackOptions, options: SmoothingOptions) -> None:
        self._held: list[Held] = []
        self._track_options, self._options = track_options, options

    def relabel(self, earlier: Mapping[int, tuple[Mapping[int, I64], float]]) -> None:
        """Add points of recognised people to held frames; see ``JointTracking.pop_recognised``."""
        for label, (points, confidence) in earlier.items():
            for at, held in enumerate(self._held):
                state, own = held.result.tracks.get(label), points.get(held.view.number)
                if state is not None and own is not None:
                    taken = np.concatenate([own[:0], *held.result.assignments.values()])
                    state = replace(state, state="tracked", confidence=confidence)
                    own = own[~np.isin(own, taken)]
                    self._held[at] = held.improve(label, state, own)

    def take(
        self,
        new: Held,
        tracks: Mapping[int, Track],
        background: Background,
        pending: Collection[int] = (),
    ) -> Iterator[FrameResult]:
        """Add the next frame, and yield the final results; frames ``pending`` are held as well."""
        small = {n: track for n, track in tracks.items() if _stiff(track)}
        for label, track in small.items():
            if new.sure(label) and any(held.open(label) for held in self._held):
                self._smooth_backward(track, new, background)
        self._held.append(new)
        while self._held and (
            len(self._held) > self._options.lag_frames
            or not (
                self._held[0].view.number in pending
                or any(self._held[0].open(label) for label in small)
            )
        ):
            yield self._held.pop(0).result

    def flush(self) -> Iterator[FrameResult]:
        """Yield the results held at the end of a run."""
        for held in self._held:
            yield held.result
        self._held = []

    def _smooth_backward(self, track: Track, new: Held, background: Background) -> None:
        """Track a copy of an object backward from a ``new`` frame through its uncertain frames."""
        label = track.label
        track_copy = replace(
            track,
            model=deepcopy(track.model),
            motion=Motion(track.options.search, track.motion.centre, track.motion.poses[-1:]),
            carving_views=list(track.carving_views),
        )
        astray: dict[int, int] = {}
        first = next(i for i, held in enumerate(self._held) if held.open(label))
        for at in range(len(self._held) - 1, first - 1, -1):
            held = self._held[at]
            known = held.result.tracks.get(label)
            if known is None or known.state == "painted":  # where it was gone back from before
                return
            cap = new.confidence_caps.get(label, 1.0)
            outcome = _find_backward(track_copy, astray, held, background, cap, self._track_options)
            self._held[at] = held.improve(label, outcome.state, outcome.points)


def _find_backward(
    track: Track,
    astray: dict[int, int],
    held: Held,
    background: Background,
    confidence_cap: float,
    track_options: TrackOptions,
) -> Outcome:
    """Find an object in the unassigned points of an earlier frame, and update it.

    ``astray``: see ``find_astray``.
    """
    view, label = held.view, track.label
    free = held.free.copy()
    for other, points in held.result.assignments.items():
        if other != label:
            free[points] = False
    associations = Associations(view, background, free)
    search = crop(track, view, background, free)
    if search is not None:
        associations = associations.put(label, register_and_claim(track, view, search))
    associations = find_astray([track], astray, associations)
    grown = grow({label: track}, associations)
    found, given = associations.found.get(label), grown.labelled.get(label)
    outcome = settle(track, view, found, given, track_options, confidence_cap)
    if found is not None and given is not None:
        fit, taken = found.registration, grown.taken
        taken[given.neutral] = True
        set_other_movers(track, view, fit.moving[~taken[fit.moving]], fit.box)
    return outcome


def _stiff(track: Track) -> bool:
    """Return whether an object is small and stiff, so that its later model is valid earlier."""
    return track.hand_sized and track.stiff


def _confidence(state: TrackState | None) -> float:
    return 0.0 if state is None else state.confidence
