"""A drive past parked cars comes in by the command line, and the cars are kept whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pointbrush.tracking import Seed
from pointbrush_samples.driving import drive
from tests.work.known_truth import imported, overlap, tracked

COMING = 5
"""Label of a parked car of 245 points, of which ever more comes into sight."""


def test_a_parked_car_has_what_comes_into_sight_of_it(tmp_path: Path) -> None:
    street, workspace = tmp_path / "street", tmp_path / "workspace"
    street.mkdir()
    for number, turn in enumerate(drive(816, 7)):
        frame = turn.frame
        np.savez(
            street / f"{number:04}.npz",
            xyz=frame.xyz,
            intensity=frame.intensity,
            viewpoint=frame.viewpoint,
            pose=turn.T_room_frame,
            truth=turn.instance,
        )
    frames, truths = imported(street, workspace)
    labels = [n for n in np.unique(truths[0]).tolist() if n and (truths[0] == n).sum() >= 40]
    seeds = [Seed(n, np.flatnonzero(truths[0] == n)) for n in labels]
    shares = [overlap(result, truths, COMING) for result in tracked(frames, seeds)]
    assert np.mean(shares) > 0.94
