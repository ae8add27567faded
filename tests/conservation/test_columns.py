"""Values of a source leave in each export as they came, or the export says that they do not."""

from __future__ import annotations

import re
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.formats import EXPORTS, read
from pointbrush.formats.registry import BUILT_IN, format_by_name
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.conservation.outputs import READERS, Columns
from tests.conservation.sources import COUNT, SOURCES, Source, coordinates

DOCS = Path(__file__).parents[2] / "docs" / "formats-written.md"
FIELDS = "other point fields"
WIDE = "integers beyond 2^53"
SINGLE = "coordinates beyond 32-bit floats"
LAS_GRID = 1e-7
"""Metres by which the whole numbers of LAS, times its scale, differ from decimals."""


@pytest.fixture(scope="module", params=SOURCES)
def exported(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Source, dict[str, Columns]]:
    """Import a source, label all its points, and export it in each format."""
    folder, name = tmp_path_factory.mktemp("conserved"), str(request.param)
    source = SOURCES[name]
    source.write(folder / name, coordinates(far=source.far), source.columns)
    place = folder / "ws" / "sequences" / "scan"
    import_frames(read(folder / name), place, RecordingInfo("scan", "Scan", 10.0))
    with closing(Workspace(Settings(workspace=folder / "ws"))) as workspace:
        label = workspace.labels.create_label("scan", "ann", name="oak", category="tree").id
        painted = np.full(COUNT, label, np.uint16)
        workspace.annotations.put("scan", 0, painted, author="ann")
        found = {}
        for kind, reader in READERS.items():
            workspace.export("scan", kind, folder / kind)
            found[kind] = reader(folder / kind)
    return source, found


def same(got: NDArray[Any], expected: NDArray[Any]) -> bool:
    """Whether each number is the same, of whatever type; as texts have the digits of its type."""
    if expected.dtype == np.float32:
        got = got.astype(np.float32)
    if "f" in (got.dtype.kind, expected.dtype.kind):
        return np.array_equal(got.astype(float), expected.astype(float), equal_nan=True)
    return got.tolist() == expected.tolist()


def of_source(got: Columns, name: str, expected: NDArray[Any]) -> NDArray[Any] | None:
    """Return a field of the source, which may be called ``source_…``; values tell which it is."""
    called = [f"{prefix}{name}" for prefix in ("source_source_", "source_", "")]
    columns = [got[each] for each in called if each in got and len(got[each]) == COUNT]
    found = [column for column in columns if same(column, expected)]
    return next(iter(found or columns), None)


def lost(kind: str, source: Source, got: Columns) -> dict[str, str]:
    """Return the losses of an export, each with the columns that show it."""
    found: dict[str, str] = {}
    xyz = coordinates(far=source.far)
    for axis, expected in zip("xyz", xyz.T, strict=True):
        error = np.abs(got[axis].astype(expected.dtype).astype(float) - expected).max()
        single = np.abs(expected - expected.mean()).max() * 2.0**-23
        if error > (single if SINGLE in EXPORTS[kind].cannot_hold else 0) + LAS_GRID:
            found["points"] = axis
        elif error > LAS_GRID:
            found[SINGLE] = axis
    for name, expected in source.columns.items():
        mine = got.get(name) if name == "intensity" else None
        if mine is not None and same(mine, expected):
            continue
        if expected.dtype.kind == "U":
            continue  # columns of words are left out at import, with a warning
        column = of_source(got, name, expected)
        if column is None or not same(column, expected):
            near = column is not None and np.allclose(column.astype(float), expected.astype(float))
            found[WIDE if near and name == "beyond_53_bits" else FIELDS] = name
    return found


def test_each_value_is_kept_or_its_loss_stated(
    exported: tuple[Source, dict[str, Columns]],
) -> None:
    source, outputs = exported
    table = {kind: lost(kind, source, got) for kind, got in outputs.items()}
    unstated = {
        kind: {loss: name for loss, name in losses.items() if loss not in EXPORTS[kind].cannot_hold}
        for kind, losses in table.items()
    }
    assert {kind: losses for kind, losses in unstated.items() if losses} == {}


def test_points_stay_in_the_order_of_the_source(
    exported: tuple[Source, dict[str, Columns]],
) -> None:
    source, outputs = exported
    expected = np.argsort(coordinates(far=source.far)[:, 0], kind="stable").tolist()
    for kind, got in outputs.items():
        assert np.argsort(got["x"], kind="stable").tolist() == expected, kind


def test_the_sources_are_of_every_format_of_files() -> None:
    """Depth images alone have no columns: tests/formats/test_rgbd.py compares their points."""
    read_by = {entry.name for name in SOURCES if (entry := format_by_name(Path(name)))}
    assert {*read_by, "kitti", "rgbd"} == {entry.name for entry in BUILT_IN}


def test_the_documented_losses_are_those_of_the_exports() -> None:
    table = DOCS.read_text().partition("| Format | Cannot hold |")[2]
    documented = dict(re.findall(r"^\| `([\w-]+)` \| (.+) \|$", table, re.M))
    assert documented == {
        name: "; ".join(entry.cannot_hold) or "no losses" for name, entry in EXPORTS.items()
    }
