"""A crowded room comes in by the command line, and its people are followed together."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pointbrush.cli import main
from pointbrush.samples import generate, write
from pointbrush.sequences import open_sequence
from pointbrush.tracking import METHODS, Seed, TrackOptions


def test_people_are_followed_together_beside_a_bag_and_a_ball(tmp_path: Path) -> None:
    room, workspace = tmp_path / "room", tmp_path / "workspace"
    write(generate("crowd", 4, 6, rate=5.0, people=3), room, step=2)
    assert main(["import", str(room), "--name", "room", "--workspace", str(workspace)]) == 0
    frames = list(open_sequence(next((workspace / "sequences").iterdir())))
    truths = []
    for frame in frames:
        with np.load(room / f"{frame.index:04}.npz") as archive:
            truths.append(archive["truth"][frame.source_index])
    seeds = [Seed(int(n), np.flatnonzero(truths[0] == n)) for n in np.unique(truths[0]) if n]
    run = METHODS["auto"]().track(
        frames.__getitem__, range(len(frames)), seeds, lambda _: None, TrackOptions()
    )
    shares: dict[int, list[float]] = {seed.label: [] for seed in seeds}
    for result in list(run)[1:]:
        for label, found_before in shares.items():
            truth = truths[result.frame] == label
            found = np.zeros(len(truth), np.bool_)
            found[result.assignments.get(label, np.empty(0, np.int64))] = True
            if truth.sum() >= 40:
                found_before.append(float((found & truth).sum() / (found | truth).sum()))
    assert len(seeds) == 5
    assert np.mean([share for label in (1, 2, 3) for share in shares[label]]) > 0.85
    # The sides of the bag that come into sight are not taken for its bearer's.
    assert min(shares[4]) > 0.9
