"""A crowded room comes in by the command line, and its people are followed together."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pointbrush.samples import generate, write
from pointbrush.tracking import Seed
from tests.work.known_truth import imported, overlap, tracked


def test_people_are_followed_together_beside_a_bag_and_a_ball(tmp_path: Path) -> None:
    room, workspace = tmp_path / "room", tmp_path / "workspace"
    write(generate("crowd", 4, 6, rate=5.0, people=3), room, step=2)
    frames, truths = imported(room, workspace)
    seeds = [Seed(int(n), np.flatnonzero(truths[0] == n)) for n in np.unique(truths[0]) if n]
    shares: dict[int, list[float]] = {seed.label: [] for seed in seeds}
    for result in tracked(frames, seeds):
        for label, found in shares.items():
            # Of the few pixels of a bag that leaves the picture, the noise decides on a tenth.
            if (truths[result.frame] == label).sum() >= (200 if label == 4 else 40):
                found.append(overlap(result, truths, label))
    assert len(seeds) == 5
    assert np.mean([share for label in (1, 2, 3) for share in shares[label]]) > 0.85
    # The sides of the bag that come into sight are not taken for its bearer's.
    assert len(shares[4]) == 3
    assert min(shares[4]) > 0.9
