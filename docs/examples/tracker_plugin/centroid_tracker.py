"""Add a tracking method for objects that move without turning.

    pip install docs/examples/tracker_plugin
    pointbrush track juggling --from 0 --to 5 --method centroid

The method moves each label by its last step, takes the points near the predicted position, and
corrects the position by their centroid.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pointbrush.tracking import FrameResult, Frames, Known, Seed, TrackOptions, TrackState

REACH = 0.1
"""Greatest distance of a point from the predicted object, metres."""


class Centroid:
    """The tracking method; pointbrush creates an instance for each run."""

    def track(
        self,
        frames: Frames,
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,  # noqa: ARG002 – existing labels, which this method ignores
        options: TrackOptions,  # noqa: ARG002
    ) -> Iterator[FrameResult]:
        """Yield a result for each frame of ``order``; its first frame is painted."""
        start = frames(order[0])
        shape = {seed.label: np.asarray(start.xyz[seed.indices], np.float64) for seed in seeds}
        moved = {label: np.zeros(3) for label in shape}
        step = {label: np.zeros(3) for label in shape}
        for number in order:
            frame = frames(number)
            found, tracks = {}, {}
            for label, points in shape.items():
                guess = moved[label] + step[label]
                taken = self._near(frame, points + guess)
                if len(taken):
                    middle = frame.xyz[taken].mean(axis=0) - points.mean(axis=0)
                    step[label], moved[label] = middle - moved[label], middle
                share = min(1.0, len(taken) / len(points))
                T_frame_start = np.eye(4)
                T_frame_start[:3, 3] = moved[label]
                state = "tracked" if len(taken) else "lost"
                found[label] = taken
                tracks[label] = TrackState(T_frame_start, 0.0, share, share, len(taken), state)
            yield FrameResult(number, found, tracks)

    @staticmethod
    def _near(frame: object, points: np.ndarray) -> np.ndarray:
        distance, near = frame.kdtree.query(points, distance_upper_bound=REACH)
        return np.unique(near[np.isfinite(distance)])
