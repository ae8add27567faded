"""The tracker under development: small objects before a depth camera."""

from __future__ import annotations

import numpy as np
import scenes

from pointbrush.tracking import Seed, TrackOptions
from pointbrush.tracking.anew.tracker import NextTracker


def test_pins_of_which_little_was_painted_are_followed_whole():
    frames = scenes.juggling(1, 14)
    truth = frames[0].truth
    seeds = [Seed(n, np.flatnonzero(truth == n)) for n in np.unique(truth).tolist() if n]
    run = NextTracker().track(
        frames.__getitem__, range(len(frames)), seeds, lambda _: None, TrackOptions()
    )
    shares = []
    for result in list(run)[1:]:
        for seed in seeds:
            own = np.flatnonzero(frames[result.frame].truth == seed.label)
            found = result.assignments.get(seed.label, own[:0])
            if len(own) >= 40:
                shares.append(len(np.intersect1d(own, found)) / len(np.union1d(own, found)))
    assert np.mean(shares) > 0.9
