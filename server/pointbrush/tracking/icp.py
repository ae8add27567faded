"""The paper's tracker: ICP or colour ICP from frame to frame, labels to the points nearby.

For each label: register the object's points to the next frame with ICP (Besl and McKay 1992), give
the label to the next frame's points near the moved object, and continue from these.  ``icp``
pairs each point with the closest one; ``color-icp`` with the one of most similar colour among
the k closest.  Both use the frames' stored k-d trees.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.tracking.compute.rigid import IcpStep, Pair, icp, inverse, transform
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
from pointbrush.tracking.model.icp_confidence import IcpEvidence
from pointbrush.tracking.options.confidence import IcpConfidenceOptions
from pointbrush.tracking.permissions import FrameRules

LONE, FINEST = 0.01, 1e-4
"""Spacing in metres of a single point, and minimum spacing of coincident points."""
SAMPLE = 500
"""Number of points sampled for the spacing."""


def nearest(tree: cKDTree, xyz: F64, k: int | NDArray[np.int64]) -> tuple[F64, I64]:
    """Return distances and indices of each point's nearest neighbours: (M,) for one or (M, k)."""
    distance, index = tree.query(xyz, k=k)
    return np.asarray(distance, np.float64), np.asarray(index, np.int64)


def closest_point(frame: TrackFrame) -> Pair:
    """Pair each point with the closest point of ``frame``."""

    def pair(moved: F64) -> tuple[F64, I64]:
        return nearest(frame.kdtree, moved, 1)

    return pair


def most_similar_colour(frame: TrackFrame, colour: F64, k: int) -> Pair:
    """Pair each point with the most similar ``colour`` (M, 3) among its ``k`` closest points."""
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
    """Return the median distance (m) of points of a frame to their nearest neighbour."""
    if len(frame.xyz) < 2:
        return LONE
    sample = xyz[:: max(1, len(xyz) // SAMPLE)]
    distance, _ = nearest(frame.kdtree, sample, 2)
    return max(float(np.median(distance[:, 1])), FINEST)


@dataclass(frozen=True, slots=True, eq=False)
class _Painted:
    """Sample of a label's points in its painted frame, for the confidence.

    ``T_frame_start``: the object's pose in that frame; ``tree``: k-d tree of all its points there.
    """

    xyz: F64
    T_frame_start: F64
    tree: cKDTree


@dataclass(slots=True)
class _Object:
    """State of a label: last points, pose ``T_frame_start``, confidence, and painted points."""

    xyz: F64
    colour: F64
    spacing: float
    pose: F64
    painted: _Painted
    confidence: float = 1.0


@dataclass(frozen=True)
class PaperTracker:
    """The paper's loop; ``k`` = 1 is ICP, more is colour ICP.

    A point of the next frame is near the moved object within ``reach`` times its spacing.
    ``watch`` gets frame, label and each iteration of its registration; ``learn`` gets frame, label
    and the evidence of the step.
    """

    k: int = 1
    reach: float = 1.2
    confidence: IcpConfidenceOptions = field(default_factory=IcpConfidenceOptions)
    learn: Callable[[int, int, IcpEvidence], None] | None = None
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
        objects = {seed.label: _start_object(start, seed.indices, np.eye(4)) for seed in seeds}
        yield FrameResult(
            order[0], {}, {s.label: TrackState.painted(len(s.indices), np.eye(4)) for s in seeds}
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
                    tracks[label] = TrackState.painted(len(certain), track.pose)
                    objects[label] = _start_object(frame, certain, track.pose)
                    stopped.discard(label)
                elif label not in stopped:
                    frame_label = (number, label)
                    found, state = self._step(track, frame, rules, frame_label, list(objects))
                    tracks[label] = state
                    if len(found):
                        assignments[label] = found
                        objects[label] = _gone_on(track, frame, found, state)
                        rules.take(found)
                    elif not options.continue_lost:
                        stopped.add(label)
            yield FrameResult(number, assignments, tracks)

    def _step(
        self,
        track: _Object,
        frame: TrackFrame,
        rules: FrameRules,
        frame_label: tuple[int, int],
        labels: list[int],
    ) -> tuple[I64, TrackState]:
        """Return an object's points and state; ``frame_label``: number of the frame and label."""
        lost = TrackState(track.pose, 0.0, 0.0, 0.0, 0, "lost")
        if len(frame.xyz) == 0:
            return np.empty(0, np.int64), lost
        # 1. Register the object's points to the next frame.
        if self.k == 1:
            pair = closest_point(frame)
        else:
            pair = most_similar_colour(frame, track.colour, self.k)
        watch = None if self.watch is None else partial(self.watch, *frame_label)
        fit = icp(track.xyz, frame.xyz.astype(np.float64), pair, watch=watch)
        # 2. The label goes to the next frame's points near the moved object.
        moved = transform(fit.T_target_source, track.xyz)
        reach = self.reach * track.spacing
        near = [np.asarray(n, np.int64) for n in frame.kdtree.query_ball_point(moved, reach)]
        found = np.unique(np.concatenate(near))
        found = found[rules.free(labels)[found]]
        found = np.union1d(found, rules.anchors(frame_label[1]))
        if len(found) == 0:
            return found, lost
        # 3. The confidence, which the paper does not have.
        inliers = float(np.mean([len(n) > 0 for n in near]))
        pose = fit.T_target_source @ track.pose
        evidence = _evidence(track, frame, found, pose, options=self.confidence)
        if self.learn is not None:
            self.learn(*frame_label, evidence)
        sure = min(evidence.likelihood(self.confidence), track.confidence + self.confidence.regain)
        return found, TrackState(pose, fit.rmse, inliers, sure, len(found), "tracked")


def _evidence(
    track: _Object, frame: TrackFrame, found: I64, pose: F64, options: IcpConfidenceOptions
) -> IcpEvidence:
    """Return features of the points ``found`` (M,) against painted points moved by all steps."""
    painted = track.painted
    moved = pose @ inverse(painted.T_frame_start)
    distance, at = nearest(frame.kdtree, transform(moved, painted.xyz), 1)
    reach = options.on_spacings * track.spacing
    some = frame.xyz[found[:: max(1, len(found) // SAMPLE)]].astype(np.float64)
    beyond, _ = nearest(painted.tree, transform(inverse(moved), some), 1)
    return IcpEvidence(
        residual=float(np.median(distance)) / track.spacing,
        found=float(((distance < reach) & np.isin(at, found)).mean()),
        beyond=float((beyond > reach).mean()),
    )


def _start_object(frame: TrackFrame, indices: I64, pose: F64) -> _Object:
    """Return an object from painted points."""
    xyz = frame.xyz[indices].astype(np.float64)
    some = xyz[:: max(1, len(xyz) // SAMPLE)]
    painted = _Painted(some, pose, cKDTree(xyz))
    return _Object(xyz, _colour(frame, indices), spacing(xyz, frame), pose, painted)


def _gone_on(track: _Object, frame: TrackFrame, indices: I64, state: TrackState) -> _Object:
    """Return the object updated with its found points."""
    xyz = frame.xyz[indices].astype(np.float64)
    return replace(
        track,
        xyz=xyz,
        colour=_colour(frame, indices),
        spacing=spacing(xyz, frame),
        pose=state.pose,
        confidence=state.confidence,
    )


def _colour(frame: TrackFrame, indices: I64) -> F64:
    rgb = frame.rgb
    return np.zeros((len(indices), 3)) if rgb is None else rgb[indices].astype(np.float64)
