"""The paper's tracker: ICP or colour ICP from frame to frame, labels to the points nearby.

For each label: register the object's points to the next frame with ICP (Besl and McKay 1992),
give the label to the next frame's points near the moved object, go on from those.  ``icp``
pairs each point with the closest one; ``color-icp`` with the one of most similar colour among
the k closest.  Both use the frames' stored k-d trees.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.tracking.compute.rigid import IcpStep, Pair, icp, transform
from pointbrush.tracking.interface import (
    F64,
    I64,
    FrameResult,
    Frames,
    Known,
    Seed,
    TrackFrame,
    TrackOptions,
    TrackState,
)
from pointbrush.tracking.permissions import FrameRules

LONE, FINEST = 0.01, 1e-4
"""Metres between points where there is but one, and at least, where all are one point."""
SAMPLE = 500
"""Points whose nearest are asked how far they are."""


def nearest(tree: cKDTree, xyz: F64, k: int | NDArray[np.int64]) -> tuple[F64, I64]:
    """Distances and indices of each point's nearest neighbours: (M,) for one, else (M, k)."""
    distance, index = tree.query(xyz, k=k)
    return np.asarray(distance, np.float64), np.asarray(index, np.int64)


def closest_point(frame: TrackFrame) -> Pair:
    """Pair each point with the closest point of ``frame``."""

    def pair(moved: F64) -> tuple[F64, I64]:
        return nearest(frame.kdtree, moved, 1)

    return pair


def most_similar_colour(frame: TrackFrame, colour: F64, k: int) -> Pair:
    """Pair each point with the one most like its ``colour`` (M, 3) among its ``k`` closest."""
    rgb = frame.rgb
    if rgb is None:
        return closest_point(frame)
    k = min(k, len(rgb))
    target_colour = rgb.astype(np.float64)

    def pair(moved: F64) -> tuple[F64, I64]:
        distance, index = nearest(frame.kdtree, moved, np.arange(1, k + 1))
        unlike = np.linalg.norm(target_colour[index] - colour[:, None, :], axis=2)
        best = np.argmin(unlike, axis=1)
        rows = np.arange(len(moved))
        return distance[rows, best], index[rows, best]

    return pair


def spacing(xyz: F64, frame: TrackFrame) -> float:
    """Median distance (metres) from points of a frame to their nearest other point there."""
    if len(frame.xyz) < 2:
        return LONE
    sample = xyz[:: max(1, len(xyz) // SAMPLE)]
    distance, _ = nearest(frame.kdtree, sample, 2)
    return max(float(np.median(distance[:, 1])), FINEST)


@dataclass(slots=True)
class _Object:
    """A label on its way: its points where it was last found, and its pose ``T_frame_start``."""

    xyz: F64
    colour: F64
    spacing: float
    pose: F64


@dataclass(frozen=True)
class PaperTracker:
    """The paper's loop; ``k`` = 1 is ICP, more is colour ICP.

    A point of the next frame is near the moved object within ``reach`` times its spacing.
    ``watch`` gets frame, label and each iteration of its registration.
    """

    k: int = 1
    reach: float = 1.2
    watch: Callable[[int, int, IcpStep], None] | None = None

    def track(
        self,
        frames: Frames,
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,
        options: TrackOptions,
    ) -> Iterator[FrameResult]:
        """See ``Method.track``."""
        start = frames(order[0])
        objects = {seed.label: _cut(start, seed.indices, np.eye(4)) for seed in seeds}
        yield FrameResult(
            order[0], {}, {s.label: _painted(len(s.indices), np.eye(4)) for s in seeds}
        )
        stopped: set[int] = set()
        for number in order[1:]:
            frame = frames(number)
            rules = FrameRules(len(frame.xyz), known(number), options)
            assignments: dict[int, I64] = {}
            tracks: dict[int, TrackState] = {}
            for label, track in objects.items():
                certain = rules.keyframe(label)
                if certain is not None:
                    assignments[label] = certain
                    tracks[label] = _painted(len(certain), track.pose)
                    objects[label] = _cut(frame, certain, track.pose)
                    stopped.discard(label)
                elif label not in stopped:
                    watch = None if self.watch is None else partial(self.watch, number, label)
                    found, tracks[label] = self._step(
                        track, frame, rules, label, list(objects), watch
                    )
                    if len(found):
                        assignments[label] = found
                        objects[label] = _cut(frame, found, tracks[label].pose)
                        rules.take(found)
                    elif not options.continue_lost:
                        stopped.add(label)
            yield FrameResult(number, assignments, tracks)

    def _step(
        self,
        track: _Object,
        frame: TrackFrame,
        rules: FrameRules,
        label: int,
        labels: list[int],
        watch: Callable[[IcpStep], None] | None,
    ) -> tuple[I64, TrackState]:
        lost = TrackState(track.pose, 0.0, 0.0, 0.0, 0, "lost")
        if len(frame.xyz) == 0:
            return np.empty(0, np.int64), lost
        # 1. Register the object's points to the next frame.
        if self.k == 1:
            pair = closest_point(frame)
        else:
            pair = most_similar_colour(frame, track.colour, self.k)
        fit = icp(track.xyz, frame.xyz.astype(np.float64), pair, watch=watch)
        # 2. The label goes to the next frame's points near the moved object.
        moved = transform(fit.T_target_source, track.xyz)
        reach = self.reach * track.spacing
        near = [np.asarray(n, np.int64) for n in frame.kdtree.query_ball_point(moved, reach)]
        found = np.unique(np.concatenate(near))
        found = found[rules.free(labels)[found]]
        found = np.union1d(found, rules.anchors(label))
        if len(found) == 0:
            return found, lost
        # 3. How many of the object's points found one: the only confidence the paper has.
        inliers = float(np.mean([len(n) > 0 for n in near]))
        pose = fit.T_target_source @ track.pose
        return found, TrackState(pose, fit.rmse, inliers, inliers, len(found), "tracked")


def _cut(frame: TrackFrame, indices: I64, pose: F64) -> _Object:
    xyz = frame.xyz[indices].astype(np.float64)
    rgb = frame.rgb
    colour = np.zeros_like(xyz) if rgb is None else rgb[indices].astype(np.float64)
    return _Object(xyz, colour, spacing(xyz, frame), pose)


def _painted(points: int, pose: F64) -> TrackState:
    return TrackState(pose, 0.0, 1.0, 1.0, points, "painted")
