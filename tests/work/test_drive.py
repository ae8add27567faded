"""A drive past parked cars comes in by the command line, and the cars are kept whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pointbrush.cli import main
from pointbrush.samples.driving import drive
from pointbrush.sequences import open_sequence
from pointbrush.tracking import METHODS, Seed, TrackOptions

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
    assert main(["import", str(street), "--name", "street", "--workspace", str(workspace)]) == 0
    frames = list(open_sequence(next((workspace / "sequences").iterdir())))
    truths = []
    for frame in frames:
        with np.load(street / f"{frame.index:04}.npz") as archive:
            truths.append(archive["truth"][frame.source_index])
    labels = [n for n in np.unique(truths[0]).tolist() if n and (truths[0] == n).sum() >= 40]
    seeds = [Seed(n, np.flatnonzero(truths[0] == n)) for n in labels]
    run = METHODS["auto"]().track(
        frames.__getitem__, range(len(frames)), seeds, lambda _: None, TrackOptions()
    )
    shares = []
    for result in list(run)[1:]:
        truth = truths[result.frame] == COMING
        found = np.zeros(len(truth), np.bool_)
        found[result.assignments.get(COMING, np.empty(0, np.int64))] = True
        shares.append((found & truth).sum() / (found | truth).sum())
    assert np.mean(shares) > 0.94
