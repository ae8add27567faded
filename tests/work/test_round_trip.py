"""Whatever leaves comes in again with its labels, into another workspace."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from pointbrush.formats.tables.corrections import Corrections
from pointbrush.frame import PointFrame
from pointbrush.labels import Label
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.waiting import PATIENCE

FORMATS = ("ply", "pcd", "npz", "csv", "las", "laz", "semantickitti")
EXACT = {"semantickitti": 1e-3, "las": 1e-6, "laz": 1e-6}
"""Metres that a format's coordinates may be off: float32 of a shifted scan, the finest grid."""
ALPHABET = np.array(list("abcäöü 0-_."))
FRAMES = 3


@dataclass(frozen=True)
class Made:
    """A recording of random points, which are labelled at random."""

    frames: list[PointFrame]
    labels: list[np.ndarray]
    palette: dict[int, Label]


def words(rng: np.random.Generator) -> str:
    return "a" + "".join(rng.choice(ALPHABET, rng.integers(0, 12))).rstrip()


def scan(rng: np.random.Generator, *, far: bool) -> PointFrame:
    count = rng.integers(3, 40)
    xyz = rng.integers(-4000, 4000, (count, 3)) / 256
    return PointFrame(
        xyz + [400_000, 5_000_000, 100] if far else xyz.astype(np.float32),
        rgb=rng.integers(0, 256, (count, 3)).astype(np.uint8),
        intensity=rng.integers(0, 255, count).astype(np.float32),
    )


def painted(workspace: Workspace, name: str, frames: list[PointFrame]) -> Made:
    rng = np.random.default_rng(len(frames[0]))
    for category in (words(rng), "", words(rng), words(rng)):
        color = f"#{rng.integers(0, 1 << 24):06x}"
        workspace.labels.create_label(name, "ann", name=words(rng), category=category, color=color)
    palette = {label.id: label for label in workspace.labels.palette(name)}
    labels = [rng.choice([0, *palette], len(frame)).astype(np.uint16) for frame in frames]
    for index, label in enumerate(labels):
        workspace.annotations.put(name, index, label, author="ann")
    return Made(frames, labels, palette)


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Workspace, dict[str, Made]]]:
    folder, rng = tmp_path_factory.mktemp("source"), np.random.default_rng(0)
    frames = {
        name: [scan(rng, far=name == "far") for _ in range(FRAMES)] for name in ("near", "far")
    }
    for name, scans in frames.items():
        place = folder / "sequences" / name
        import_frames(scans, place, RecordingInfo(name, name, 10.0))
    with closing(Workspace(Settings(workspace=folder))) as workspace:
        yield workspace, {name: painted(workspace, name, scans) for name, scans in frames.items()}


@pytest.fixture(scope="module")
def again(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workspace]:
    """A workspace for what comes back; its worker process starts once."""
    with closing(Workspace(Settings(workspace=tmp_path_factory.mktemp("again")))) as workspace:
        yield workspace


@pytest.mark.parametrize("kind", FORMATS)
def test_points_colours_labels_palette_and_provenance_are_equal(
    tmp_path: Path, kind: str, source: tuple[Workspace, dict[str, Made]], again: Workspace
) -> None:
    workspace, recordings = source
    for name, made in recordings.items():
        workspace.export(name, kind, tmp_path / name)
        job = again.imports.begin([tmp_path / name], name=f"{name} {kind}", fps=10.0)
        done = again.runner.wait(job.id, PATIENCE)
        assert done.state == "done", done.error
        assert done.result is not None
        came_back(again, done.result["sequence"], made, kind)


def came_back(again: Workspace, name: str, made: Made, kind: str) -> None:
    """Compare a recording with what its export was imported as."""
    for index, (frame, label) in enumerate(zip(made.frames, made.labels, strict=True)):
        np.testing.assert_array_equal(again.annotations.read(name, index)[0], label)
        provenance = again.annotations.read(name, index, "provenance")[0]
        np.testing.assert_array_equal(provenance, np.where(label > 0, 3, 0))
        stored = again.recording(name)[index]
        columns = stored.read_source(0, stored.count, ["xyz", "rgb", "intensity"])
        order = np.argsort(stored.source_index)
        xyz = _world(stored.pose, columns["xyz"][order])
        if kind == "csv":
            xyz = xyz.astype(frame.xyz.dtype)  # text has no types
        np.testing.assert_allclose(xyz, frame.xyz, rtol=0, atol=EXACT.get(kind, 0.0))
        np.testing.assert_array_equal(columns["intensity"][order], frame.intensity)
        if kind != "semantickitti":
            np.testing.assert_array_equal(columns["rgb"][order], frame.rgb)
    palette = {label.id: label for label in again.labels.palette(name)}
    for label_id in set(np.concatenate(made.labels).tolist()) - {0}:
        ours, theirs = made.palette[label_id], palette[label_id]
        assert (theirs.name, theirs.category) == (ours.name, ours.category)
        assert theirs.color == ours.color


def _world(pose: np.ndarray | None, xyz: np.ndarray) -> np.ndarray:
    """Coordinates of the source: those that a pose has undone are moved back."""
    return xyz if pose is None else xyz @ pose[:3, :3].T + pose[:3, 3]


def test_labels_alone_have_a_row_for_every_row_of_the_source(tmp_path: Path) -> None:
    source = tmp_path / "scan"
    source.mkdir()
    rows = [f"{i} {i} {i} 5" for i in range(20)]
    for bad in (0, 7, 8, 19):
        rows[bad] = "nan nan nan 5"
    (source / "0.xyz").write_text("\n".join(rows))
    (source / "1.xyz").write_text("\n".join(f"{i} {i} 1 5" for i in range(20)))
    with closing(Workspace(Settings(workspace=tmp_path / "ws"))) as workspace:
        job = workspace.imports.begin([source], chosen=Corrections(drop_invalid=True))
        done = workspace.runner.wait(job.id, PATIENCE)
        assert done.state == "done", done.error
        label = workspace.labels.create_label("scan", "ann", name="a").id
        painted_ = np.zeros(16, np.uint16)
        painted_[[0, 5, 15]] = label
        workspace.annotations.put("scan", 0, painted_, author="ann")
        workspace.export("scan", "labels-only", tmp_path / "labels")
        manifest = json.loads((tmp_path / "labels" / "manifest.json").read_text())
        array = np.load(tmp_path / "labels" / "label" / "000000.npy")
        assert np.flatnonzero(array).tolist() == [1, 6, 18]
        assert len(np.load(tmp_path / "labels" / "label" / "000001.npy")) == 20
        told = manifest["frames"][0]
        assert [told[k] for k in ("rows", "points", "invalid", "labelled")] == [20, 16, 4, 3]
        assert set(told["files"]) == {
            f"{layer}/000000.npy" for layer in ("label", "provenance", "deleted")
        }
        for name, file in told["files"].items():
            data = (tmp_path / "labels" / name).read_bytes()
            assert (file["bytes"], file["sha256"]) == (len(data), hashlib.sha256(data).hexdigest())
        # … and come in again.
        workspace.labels.undo("scan", "ann")
        job = workspace.imports.begin_labels("scan", tmp_path / "labels", "bob")
        done = workspace.runner.wait(job.id, PATIENCE)
        assert done.state == "done", done.error
        np.testing.assert_array_equal(workspace.annotations.read("scan", 0)[0] > 0, painted_ > 0)
