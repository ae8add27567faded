"""Recordings with the truth beside their points, imported by the command line and tracked."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.cli import main
from pointbrush.sequences import StoredFrame, open_sequence
from pointbrush.tracking import METHODS, FrameResult, Seed, TrackOptions

Truths = list[NDArray[np.int64]]


def imported(source: Path, workspace: Path) -> tuple[list[StoredFrame], Truths]:
    """Import frames ``NNNN.npz``; returns them, and their truth in stored order."""
    assert main(["import", str(source), "--name", "made", "--workspace", str(workspace)]) == 0
    frames = list(open_sequence(next((workspace / "sequences").iterdir())))
    truths = []
    for frame in frames:
        with np.load(source / f"{frame.index:04}.npz") as archive:
            truths.append(archive["truth"][frame.source_index])
    return frames, truths


def tracked(frames: Sequence[StoredFrame], seeds: Sequence[Seed]) -> list[FrameResult]:
    """Track seeds of the first frame through all others."""
    numbers = range(len(frames))
    run = METHODS["auto"]().track(
        frames.__getitem__, numbers, list(seeds), lambda _: None, TrackOptions()
    )
    return list(run)[1:]


def overlap(result: FrameResult, truths: Truths, label: int) -> float:
    """Intersection over union of what was found of a label, and what it is."""
    truth = truths[result.frame] == label
    found = np.zeros(len(truth), np.bool_)
    found[result.assignments.get(label, np.empty(0, np.int64))] = True
    return float((found & truth).sum() / (found | truth).sum())
