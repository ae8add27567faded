"""Fit the confidence of `icp` and `color-icp` on generated recordings, and print its options.

    python benchmarks/fit_icp.py [--frames 20] [--seeds 31,32]

Frame 0 is painted with the truth; each step of both methods is a sample whose target grows from 0
at an IoU of 0.5 to 1 at 0.8.  The same seeds give the same weights, which belong into
``IcpConfidenceOptions``.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from tracking_frames import LEAST, Frame
from tracking_recordings import generated
from tracking_score import GOOD, SURVIVING

from pointbrush.tracking import Seed, TrackOptions
from pointbrush.tracking.icp import PaperTracker
from pointbrush.tracking.model.icp_confidence import IcpEvidence
from pointbrush.tracking.options.confidence import IcpConfidenceOptions
from pointbrush.tracking.registry import COLOUR_NEIGHBOURS

Samples = list[tuple[dict[str, float], float]]
SHOWN = (("3-pins", 1, 1), ("table-top", 3, 1), ("table-top", 1, 3))
"""Kinds of recording, of how many frames one is kept, and times as many frames: at 30 a second
little goes wrong on a table, and slowly."""
SHRINKAGE = 0.001
"""Weight of the squared weights beside the mean log loss."""


def samples(frames: Sequence[Frame], k: int) -> Samples:
    """Run a method over a recording: the features of each step and the IoU it came to."""
    first = frames[0].truth
    labels = [n for n in np.unique(first).tolist() if n and np.sum(first == n) >= LEAST]
    seen: dict[tuple[int, int], IcpEvidence] = {}

    def learn(number: int, label: int, evidence: IcpEvidence) -> None:
        seen[number, label] = evidence

    method = PaperTracker(k, learn=learn)
    seeds = [Seed(n, np.flatnonzero(first == n)) for n in labels]
    run = method.track(
        lambda i: frames[i],
        range(len(frames)),
        seeds,
        lambda _: None,
        TrackOptions(continue_lost=True),
    )
    made: Samples = []
    for result in run:
        truth = frames[result.frame].truth
        for label, points in result.assignments.items():
            total = int((truth == label).sum())
            if total >= LEAST and (result.frame, label) in seen:
                both = int((truth[points] == label).sum())
                features = seen[result.frame, label].features(IcpConfidenceOptions())
                made.append((features, both / (total + len(points) - both)))
    return made


def fitted(made: Samples) -> NDArray[np.float64]:
    """Weights and offset, by logistic regression on graded targets."""
    x = np.array([[*features.values(), 1.0] for features, _ in made])
    y = np.clip([(iou - SURVIVING) / (GOOD - SURVIVING) for _, iou in made], 0.0, 1.0)

    def loss(w: NDArray[np.float64]) -> float:
        odds = x @ w
        return float((np.logaddexp(0.0, odds) - y * odds).mean() + SHRINKAGE * (w[:-1] ** 2).sum())

    return np.asarray(minimize(loss, np.zeros(x.shape[1])).x)


def main() -> None:
    """Print the fitted options."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--seeds", default="31,32")
    given = parser.parse_args()
    made: Samples = []
    for seed in map(int, given.seeds.split(",")):
        for kind, every, times in SHOWN:
            count = times * given.frames
            frames = generated(kind, seed, count, every)
            for k in (1, COLOUR_NEIGHBOURS):
                made += samples(frames, k)
            print(f"{kind} {seed}: {len(made)} samples", flush=True)
    *weights, offset = np.round(fitted(made), 2).tolist()
    print(dict(zip(made[0][0], weights, strict=True)), f"offset: {offset}")


if __name__ == "__main__":
    main()
