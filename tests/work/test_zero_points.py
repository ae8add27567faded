"""Points at 0 0 0, beams without an echo, are left out, and labels are of the file's rows still."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from pointbrush.formats import Limits
from pointbrush.settings import Settings
from pointbrush.values.imports import PreviewedFrame
from pointbrush.work.imports.previewing import preview
from pointbrush.work.imports.requests import ImportRequest
from pointbrush.workspace import Workspace
from tests.serving import with_labels
from tests.waiting import PATIENCE

ROWS, KEPT = 100, 60


@pytest.mark.parametrize("ending", ["npy", "bin", "csv"])
def test_rows_of_absent_points_stay_in_the_labels(tmp_path: Path, ending: str) -> None:
    rng = np.random.default_rng(1)
    xyz = rng.uniform(1, 9, (ROWS, 3)).astype("<f4")
    zero = rng.permutation(np.arange(ROWS) >= KEPT)
    xyz[zero] = 0
    path = tmp_path / f"scan.{ending}"
    match ending:
        case "npy":
            np.save(path, xyz)
        case "bin":
            path.write_bytes(np.c_[xyz, np.full(ROWS, 0.5)].astype("<f4").tobytes())
        case _:
            path.write_text("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in xyz.tolist()))
    found = preview(ImportRequest((path,)), Limits())
    assert found.points == (PreviewedFrame(KEPT, ROWS - KEPT),)
    labels = np.arange(ROWS, dtype=np.uint16) % 3
    (tmp_path / "labels").mkdir()
    np.save(tmp_path / "labels" / "scan.npy", labels)
    with closing(Workspace(with_labels(Settings(workspace=tmp_path / "workspace")))) as workspace:
        done = workspace.runner.wait(workspace.imports.begin([path]).id, PATIENCE)
        assert done.result["dropped"] == ROWS - KEPT, done.error
        job = workspace.imports.begin_labels("scan", tmp_path / "labels", "ann")
        done = workspace.runner.wait(job.id, PATIENCE)
        assert done.state == "done", done.error
        workspace.export("scan", "labels-only", tmp_path / "out")
    back = np.load(tmp_path / "out" / "label" / "000000.npy")
    assert back.tolist() == np.where(zero, 0, labels).tolist()
