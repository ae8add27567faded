"""Fields of a source that pointbrush has no use for come out as they went in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pointbrush.errors import DamagedError
from pointbrush.formats import read
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence, verify
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.serving import with_labels


def recording(folder: Path, count: int = 50) -> PointFrame:
    rng = np.random.default_rng(2)
    frame = PointFrame(
        rng.uniform(-5, 5, (count, 3)).astype(np.float32),
        other={
            "ring": rng.integers(0, 64, count).astype(np.uint16),
            "time": rng.uniform(0, 0.1, count),
            "category": rng.integers(0, 9, count).astype(np.int32),
        },
    )
    import_frames(
        [frame, PointFrame(frame.xyz)],
        folder / "sequences" / "scan",
        RecordingInfo("scan", "Scan", 10.0),
    )
    return frame


@pytest.mark.parametrize("kind", ["ply", "pcd"])
def test_other_fields_keep_order_type_and_points(tmp_path: Path, kind: str) -> None:
    frame = recording(tmp_path)
    assert verify(tmp_path / "sequences" / "scan") == []
    workspace = Workspace(with_labels(Settings(workspace=tmp_path)))
    try:
        label = workspace.labels.create_label("scan", "me", name="car").id
        x, y, z = (float(v) for v in frame.xyz[7])
        workspace.strokes.apply(
            "scan",
            0,
            {"tool": "delete", "radius": 0.01, "samples": [{"origin": [x, y, z]}]},
            "me",
        )
        assert label == 1
        workspace.export("scan", kind, tmp_path / "out")
    finally:
        workspace.close()
    again = next(read(tmp_path / "out" / f"000000.{kind}"))
    kept = np.delete(np.arange(50), 7)
    # The palette's own category has the name; the source's one is not lost for it.
    assert list(again.other) == ["category", "ring", "time", "source_category"]
    for name in ("ring", "time"):
        assert again.other[name].dtype == frame.other[name].dtype
        assert np.array_equal(again.other[name], frame.other[name][kept])
    assert np.array_equal(again.other["source_category"], frame.other["category"][kept])
    assert "ring" not in next(read(tmp_path / "out" / f"000001.{kind}")).other


def test_fields_of_before_manifest_version_4_are_read(tmp_path: Path) -> None:
    frame = recording(tmp_path)
    place = tmp_path / "sequences" / "scan" / "fields"
    (place / "000000.fields").unlink()
    parts = {"000000.000000000000.npz": slice(0, 30), "000000.000000000030.npz": slice(30, 50)}
    for name, part in parts.items():
        columns = {f"field_{k}": values[part] for k, values in enumerate(frame.other.values())}
        np.savez_compressed(place / name, names=np.array(list(frame.other)), **columns)
    found = open_sequence(tmp_path / "sequences" / "scan").other_of(0, 20, 40)
    assert list(found) == list(frame.other)
    for name, values in found.items():
        assert values.dtype == frame.other[name].dtype
        assert np.array_equal(values, frame.other[name][20:40])


def test_damaged_fields_are_told_and_nothing_is_written(tmp_path: Path) -> None:
    recording(tmp_path)
    path = tmp_path / "sequences" / "scan" / "fields" / "000000.fields"
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(bytes(data))
    workspace = Workspace(with_labels(Settings(workspace=tmp_path)))
    try:
        with pytest.raises(DamagedError, match="frame 0: expected its further fields"):
            workspace.export("scan", "ply", tmp_path / "out")
    finally:
        workspace.close()
    assert not (tmp_path / "out").exists()
