"""Objects of a lived-in home, whose scan comes from a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import plyfile
import pytest
from numpy.typing import NDArray

from pointbrush.cli import main
from pointbrush.selection.objects import candidates, prepare
from pointbrush.sequences import open_sequence
from pointbrush.work.objects.frames import object_frame
from pointbrush_samples.scanning import FUSED, Labelled, home_scan

LARGEST = 12
"""Objects that are clicked."""


@pytest.fixture(scope="module")
def home() -> Labelled:
    return home_scan(41, replace(FUSED, points=80_000, views=10))


def imported(folder: Path, made: Labelled) -> Path:
    """The recording of a scan's file after ``pointbrush import``."""
    columns = [*np.asarray(made.frame.xyz, np.float32).T]
    assert made.frame.rgb is not None
    rows = np.rec.fromarrays([*columns, *made.frame.rgb.T], names="x,y,z,red,green,blue")
    plyfile.PlyData([plyfile.PlyElement.describe(rows, "vertex")]).write(folder / "home.ply")
    workspace = folder / "workspace"
    asked = ["import", str(folder / "home.ply"), "--up=y", "--workspace", str(workspace)]
    assert main(asked) == 0
    return next((workspace / "sequences").iterdir())


def middle(xyz: NDArray[np.floating]) -> NDArray[np.float64]:
    """The point (1, 3) nearest to the median."""
    return np.asarray(xyz[[np.linalg.norm(xyz - np.median(xyz, 0), axis=1).argmin()]], float)


def overlap(taken: NDArray[np.int64], truth: NDArray[np.bool_]) -> float:
    mask = np.zeros(len(truth), np.bool_)
    mask[taken] = True
    return float((mask & truth).sum() / (mask | truth).sum())


def test_a_click_on_the_things_of_a_home_offers_them(tmp_path: Path, home: Labelled) -> None:
    recording = open_sequence(imported(tmp_path, home))
    frame = object_frame(recording[0], recording.manifest)
    instance = home.instance[recording[0].source_index]
    state = prepare(frame)
    numbers, counts = np.unique(instance[instance > 0], return_counts=True)
    best, shown = [], []
    for number in numbers[np.argsort(-counts)[:LARGEST]]:
        truth = instance == number
        found = candidates(state, middle(frame.xyz[truth]))
        shown.append(overlap(found[0].indices, truth))
        best.append(max(overlap(each.indices, truth) for each in found))
    assert np.mean(best) > 0.72
    assert np.mean(shown) > 0.68
