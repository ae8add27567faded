"""Fixed-lag smoothing: doubtful frames are tracked backward from the next sure one.

Source: two-filter smoothing, Fraser and Potter 1969.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from pointbrush.tracking.anew.track import Track
from pointbrush.tracking.interface import I64, FrameResult, Mask, TrackState
from pointbrush.tracking.model.motion import Motion
from pointbrush.tracking.options.tracks import SmoothingOptions
from pointbrush.tracking.sensors.view import View


@dataclass(frozen=True, eq=False)
class Held:
    """A result that is held back; ``free`` (N,): points the run may take; ``done``: labels."""

    view: View
    free: Mask
    result: FrameResult
    caps: Mapping[int, float]
    done: frozenset[int] = frozenset()


Back = Callable[[Track, Held, Mask], tuple[Track, TrackState, I64]]
"""One step of a single track in the free points of a held frame."""


def _confidence(held: Held, label: int) -> float:
    state = held.result.tracks.get(label)
    return 0.0 if state is None else state.confidence


@dataclass
class Smoother:
    """Holds the last frames of a run."""

    options: SmoothingOptions
    back: Back
    held: list[Held] = field(default_factory=list)

    def _open(self, held: Held, label: int) -> bool:
        known = label in held.result.tracks and label not in held.done
        return known and _confidence(held, label) < self.options.sure

    def take(self, new: Held, tracks: Mapping[int, Track]) -> Iterator[FrameResult]:
        """Add a frame, and yield the results that are final."""
        for label, track in tracks.items():
            sure = _confidence(new, label) >= self.options.sure
            if sure and not track.soft and any(self._open(each, label) for each in self.held):
                self._smooth(track)
        self.held.append(new)
        while self.held and (
            len(self.held) > self.options.lag_frames
            or not any(self._open(self.held[0], n) for n in tracks)
        ):
            yield self.held.pop(0).result

    def flush(self) -> Iterator[FrameResult]:
        """Yield all that is held."""
        while self.held:
            yield self.held.pop(0).result

    def _smooth(self, track: Track) -> None:
        label = track.label
        motion = Motion(track.options.search, track.motion.centre, track.motion.poses[-1:])
        track = replace(track, motion=motion)
        first = next(i for i, held in enumerate(self.held) if self._open(held, label))
        for at in range(len(self.held) - 1, first - 1, -1):
            held = self.held[at]
            known = held.result.tracks.get(label)
            if known is None or known.state == "painted":
                return
            free = held.free.copy()
            for other, points in held.result.assignments.items():
                if other != label:
                    free[points] = False
            track, state, points = self.back(track, held, free)
            result = held.result
            if state.confidence > known.confidence:
                result = replace(
                    result,
                    assignments={**result.assignments, label: points},
                    tracks={**result.tracks, label: state},
                )
            self.held[at] = replace(held, result=result, done=held.done | {label})
