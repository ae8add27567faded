"""Facts that an import states of scans: no rate of a single one, the axis that is up, no points."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest

from pointbrush.commands.importing import imported
from pointbrush.errors import BadInputError
from pointbrush.formats import Limits
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.settings import Settings
from pointbrush.work.imports.previewing import preview
from pointbrush.work.imports.requests import ImportRequest
from pointbrush.workspace import Workspace
from tests.serving import with_labels
from tests.waiting import PATIENCE

RNG = np.random.default_rng(0)
XYZ = np.concatenate(
    [RNG.uniform(0, [9, 8, 0.01], (2000, 3)), RNG.uniform(3, 4, (500, 3)) * [1, 1, 0.3]]
)
"""A floor, and a box that hovers over it."""


def npy(path: Path, xyz: np.ndarray = XYZ) -> Path:
    path.parent.mkdir(exist_ok=True)
    np.save(path, xyz.astype(np.float32))
    return path


def las(path: Path, xyz: np.ndarray = XYZ) -> Path:
    path.parent.mkdir(exist_ok=True)
    cloud = laspy.LasData(laspy.LasHeader(point_format=3, version="1.2"))
    cloud.x, cloud.y, cloud.z = xyz.T
    cloud.write(path)
    return path


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    opened = Workspace(with_labels(Settings(workspace=tmp_path / "workspace")))
    yield opened
    opened.close()


def bring(workspace: Workspace, path: Path, **options: Any) -> dict[str, Any]:
    done = workspace.runner.wait(workspace.imports.begin([path], **options).id, PATIENCE)
    assert done.state == "done", done.error
    return dict(done.result or {})


@pytest.mark.parametrize(("write", "ending"), [(npy, "npy"), (las, "las")])
def test_a_single_scan_has_no_rate(
    workspace: Workspace, tmp_path: Path, write: Callable[[Path], Path], ending: str
) -> None:
    path = write(tmp_path / "in" / f"hall.{ending}")
    found = preview(ImportRequest((path,)), Limits())
    assert (found.fps, found.fps_from) == (1, "a single scan")
    result = bring(workspace, path)
    assert (result["fps"], result["warnings"]) == (1, [])
    assert workspace.recording("hall").manifest.fps == 1
    assert bring(workspace, path, name="fast", fps=5.0)["fps"] == 5


@pytest.mark.parametrize(("write", "ending", "fps"), [(npy, "npy", 30), (las, "las", 1)])
def test_scans_of_a_survey_are_no_film(
    workspace: Workspace, tmp_path: Path, write: Callable[[Path], Path], ending: str, fps: float
) -> None:
    for k in range(2):
        path = write(tmp_path / "halls" / f"{k}.{ending}")
    found = preview(ImportRequest((path.parent,)), Limits())
    assert (found.fps, found.fps_from) == (fps, "assumed")
    result = bring(workspace, path.parent)
    assert result["fps"] == fps
    assert f"the rate of {fps} frames a second is assumed" in " ".join(result["warnings"])


@pytest.mark.parametrize(
    ("xyz", "given", "up", "source"),
    [
        (XYZ, None, "z", "guessed"),
        (XYZ[:, [0, 2, 1]], None, "y", "guessed"),
        (XYZ, "-x", "-x", "given"),
        (XYZ + [4e5, 5e6, 100], None, "z", "map"),
    ],
)
def test_a_guessed_axis_is_stated(
    workspace: Workspace, tmp_path: Path, xyz: np.ndarray, given: str | None, up: str, source: str
) -> None:
    path, chosen = tmp_path / "hall.npy", Corrections(up=given)
    np.save(path, xyz)
    found = preview(ImportRequest((path,), chosen=chosen), Limits())
    result = bring(workspace, path, chosen=chosen)
    assert (found.up, found.up_from) == (result["up"], result["up_from"]) == (up, source)
    lines = " ".join(imported(result).lines)
    assert (f"up is {up}, guessed" in lines) == (source == "guessed")


def test_an_empty_tile_says_so(workspace: Workspace, tmp_path: Path) -> None:
    path = las(tmp_path / "tiles" / "empty.las", XYZ[:0])
    told = r"empty\.las: expected points, got none in 1 frame\(s\): the file says 0 points"
    with pytest.raises(BadInputError, match=told):
        preview(ImportRequest((path,)), Limits())
    las(path.with_name("full.las"))
    warnings = " ".join(bring(workspace, path.parent)["warnings"])
    assert "empty.las: the file is empty: its header says 0 points" in warnings


def test_a_file_of_zeros_alone_says_so(workspace: Workspace, tmp_path: Path) -> None:
    path = npy(tmp_path / "zeros.npy", np.zeros((9, 3)))
    done = workspace.runner.wait(workspace.imports.begin([path]).id, PATIENCE)
    assert done.state == "failed"
    assert "zeros.npy: expected points" in str(done.error)
    assert "9 are NaN, infinite or at 0 0 0" in str(done.error)
