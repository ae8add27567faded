"""Confidence of similar objects that may have been exchanged.

When two objects meet, each is found at its own prediction or at the other's.  If an exchange
explains the frame about as well, neither this frame nor later appearances resolve the identities;
only smooth trajectories before and after the meeting do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from pointbrush.tracking.interface import F64
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options.tracks import IdentityOptions

Pair = tuple[int, int]


@dataclass(eq=False)
class Meeting:
    """Two objects that may have been exchanged; ``confidence_cap``: their maximum confidence.

    ``before`` (2, M, 3): their positions before the meeting; ``after``: positions in the frame of
    the meeting and later, None if one of them was not seen.
    """

    options: IdentityOptions
    confidence_cap: float
    before: F64
    after: list[F64 | None] = field(default_factory=list)

    def kept_places(self) -> bool:
        """Return whether the trajectories prove that the two were not exchanged."""
        options = self.options
        late = [both for both in self.after[1:] if both is not None]
        if len(late) < options.compared_frames or not self.before.shape[1]:
            return False
        after = np.stack(late, axis=1)
        as_found = _unsteady(np.concatenate([self.before, after], axis=1), options=options)
        return as_found < options.smooth_ratio * _unsteady(
            np.concatenate([self.before, after[::-1]], axis=1), options=options
        )


class Swaps:
    """All pairs of similar small objects of a run that met."""

    def __init__(self, options: IdentityOptions) -> None:
        self.options = options
        self.meetings: dict[Pair, Meeting] = {}

    def meet(
        self, tracks: Mapping[int, Track], fits: Mapping[int, Registration]
    ) -> dict[int, float]:
        """Record the positions of objects; return maximum confidences by label after meetings."""
        at = {n: _middle(tracks[n], fit) for n, fit in fits.items() if tracks[n].hand_sized}
        ahead: dict[int, F64] = {}
        for pair in combinations(sorted(at), 2):
            if pair not in self.meetings and _may_be_changed(
                tracks, at, pair, options=self.options
            ):
                for label in pair:
                    if label not in ahead:
                        ahead[label] = _predicted(tracks[label])
                self._compare(tracks, at, ahead, pair)
        self._go_on(at)
        caps: dict[int, float] = {}
        for pair, meeting in self.meetings.items():
            for label in pair:
                if label in fits:
                    caps[label] = min(caps.get(label, 1.0), meeting.confidence_cap)
        return caps

    def forget(self, label: int) -> None:
        """End the meetings of an object confirmed by a person."""
        self.meetings = {pair: of for pair, of in self.meetings.items() if label not in pair}

    def _compare(
        self, tracks: Mapping[int, Track], at: dict[int, F64], ahead: dict[int, F64], pair: Pair
    ) -> None:
        """Start a meeting if two objects may have been exchanged in this frame."""
        options = self.options
        one, other = pair
        rough = sum((options.prediction_units * tracks[n].unit) ** 2 for n in pair)
        kept = _squared_error(ahead[one], at[one]) + _squared_error(ahead[other], at[other]) + rough
        # Exchanged objects continue to move: the prediction at rest is left out.
        swapped = (
            _squared_error(ahead[one][:-1], at[other])
            + _squared_error(ahead[other][:-1], at[one])
            + rough
        )
        if kept < options.uneven_ratio * swapped or not _look_alike(tracks[one], tracks[other]):
            return
        confidence_cap = (
            options.unsure_confidence
            if kept < options.even_ratio * swapped
            else options.doubted_confidence
        )
        self.meetings[pair] = Meeting(
            self.options, confidence_cap, _recent_paths(tracks[one], tracks[other])
        )

    def _go_on(self, at: Mapping[int, F64]) -> None:
        """Add positions to all meetings, and end the meetings that they resolve."""
        for (one, other), meeting in list(self.meetings.items()):
            if len(meeting.after) <= self.options.compared_frames:
                seen = one in at and other in at
                meeting.after.append(np.stack([at[one], at[other]]) if seen else None)
                if meeting.kept_places():
                    del self.meetings[one, other]


def _middle(track: Track, fit: Registration) -> F64:
    return np.asarray(fit.pose[:3, :3] @ track.motion.centre + fit.pose[:3, 3])


def _predicted(track: Track) -> F64:
    """Return (K, 3) predicted centres of an object, the one at rest last."""
    poses = track.motion.predictions
    poses = poses if len(poses) > 1 else np.repeat(poses, 2, axis=0)
    return np.asarray(poses[:, :3, :3] @ track.motion.centre + poses[:, :3, 3])


def _may_be_changed(
    tracks: Mapping[int, Track], at: Mapping[int, F64], pair: Pair, options: IdentityOptions
) -> bool:
    """Return whether two objects are near, and not both clearly nearer to their own predictions.

    This cheap test runs for all pairs in each frame, before the full predictions.
    """
    one, other = (tracks[n] for n in pair)
    apart = float(np.linalg.norm(at[pair[0]] - at[pair[1]]))
    if apart > sum(track.model.radius + track.motion.speed for track in (one, other)):
        return False
    off = max(float(np.linalg.norm(tracks[n].motion.extrapolated_place - at[n])) for n in pair)
    return off > options.clear_share * apart or apart < options.meeting_units * max(
        one.unit, other.unit
    )


def _squared_error(ahead: F64, at: F64) -> float:
    """Return the squared distance to the nearest prediction."""
    offset = ahead - at
    return float(np.einsum("ij,ij->i", offset, offset).min())


def _look_alike(one: Track, other: Track) -> bool:
    options = one.options.identity
    sizes = sorted(track.model.radius for track in (one, other))
    if sizes[1] > options.alike_radius_ratio * sizes[0]:
        return False
    shares = (a.appearance.share(b.model.colour) for a, b in ((one, other), (other, one)))
    return min(shares) > one.options.appearance.alike_share


def _recent_paths(one: Track, other: Track) -> F64:
    """Return (2, M, 3) centres of both in the last frames; empty if one was occluded."""
    motions = [one.motion, other.motion]
    count = min(len(motion.poses) if motion.gap == 1 else 0 for motion in motions)
    poses = np.stack([motion.poses[len(motion.poses) - count :] for motion in motions])
    if not count:
        return np.empty((2, 0, 3))
    centres = np.stack([motion.centre for motion in motions])
    return np.asarray(np.einsum("kmij,kj->kmi", poses[..., :3, :3], centres) + poses[..., :3, 3])


def _unsteady(ways: F64, options: IdentityOptions) -> float:
    """Return the residual sum of squares of two trajectories (2, M + FRAMES, 3).

    They have M frames before a meeting and FRAMES after it.  The model is a constant velocity with
    a common acceleration of free fall.
    """
    early = ways.shape[1] - options.compared_frames
    time = np.array([*range(-early, 0), *range(1, options.compared_frames + 1)], np.float64)
    even = np.stack([np.ones_like(time), time], axis=1)
    rest = np.eye(len(time)) - even @ np.linalg.pinv(even)
    off, fall = rest @ ways, rest @ time**2
    gravity = (fall @ off).mean(axis=0) / (fall @ fall)
    return float(((off - fall[:, None] * gravity) ** 2).sum())
