"""Whatever leaves comes in again with its labels, into a workspace that knows nothing of it."""

from __future__ import annotations

import hashlib
import json
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from pointbrush.formats.corrections import Corrections
from pointbrush.frame import PointFrame
from pointbrush.sequences import import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests.waiting import PATIENCE

FORMATS = ("ply", "pcd", "npz", "csv", "las", "laz", "semantickitti")
EXACT = {"semantickitti": 1e-3, "las": 1e-6, "laz": 1e-6}
"""Metres that a format's coordinates may be off: float32 of a shifted scan, the finest grid."""
TEXT = st.text("abcäöü 0-_.", min_size=1, max_size=12).map(str.strip).filter(bool)
COLOR = st.integers(0, 0xFFFFFF).map("#{:06x}".format)


@st.composite
def recordings(draw: st.DrawFn) -> tuple[list[PointFrame], list[tuple[str, str, str]]]:
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    far = draw(st.booleans())
    frames = []
    for _ in range(draw(st.integers(1, 2))):
        count = draw(st.integers(3, 40))
        xyz = rng.integers(-4000, 4000, (count, 3)) / 256
        frames.append(
            PointFrame(
                xyz + [400_000, 5_000_000, 100] if far else xyz.astype(np.float32),
                rgb=rng.integers(0, 256, (count, 3)).astype(np.uint8),
                intensity=rng.integers(0, 255, count).astype(np.float32),
            )
        )
    names = draw(st.lists(TEXT, min_size=1, max_size=4, unique=True))
    return frames, [(name, draw(TEXT | st.just("")), draw(COLOR)) for name in names]


def imported(folder: Path, path: Path) -> Workspace:
    """A workspace into which an export was imported as ``again``."""
    workspace = Workspace(Settings(workspace=folder))
    job = workspace.import_paths([path], name="again", fps=10.0)
    done = workspace.runner.wait(job.id, PATIENCE)
    assert done.state == "done", done.error
    return workspace


def painted(
    folder: Path, frames: list[PointFrame], palette: list[tuple[str, str, str]], seed: int
) -> tuple[Workspace, list[np.ndarray]]:
    place = folder / "sequences" / "made"
    import_frames(frames, place, sequence_id="made", name="made", fps=10.0)
    workspace = Workspace(Settings(workspace=folder))
    ids = [
        workspace.create_label("made", "ann", name=name, category=category, color=color).id
        for name, category, color in palette
    ]
    rng = np.random.default_rng(seed)
    labels = [rng.choice([0, *ids], len(frame)).astype(np.uint16) for frame in frames]
    for index, label in enumerate(labels):
        workspace.put_annotation("made", index, label, author="ann")
    return workspace, labels


@pytest.mark.parametrize("kind", FORMATS)
@settings(
    max_examples=3,
    deadline=None,
    suppress_health_check=list(HealthCheck),
    derandomize=True,
    phases=[Phase.generate],
)
@given(made=recordings(), seed=st.integers(0, 1000))
def test_points_colours_labels_palette_and_provenance_are_equal(
    tmp_path_factory: pytest.TempPathFactory,
    kind: str,
    made: tuple[list[PointFrame], list[tuple[str, str, str]]],
    seed: int,
) -> None:
    folder = tmp_path_factory.mktemp("trip")
    frames, palette = made
    workspace, labels = painted(folder / "one", frames, palette, seed)
    with closing(workspace):
        workspace.export("made", kind, folder / "out")
        first = {label.id: label for label in workspace.palette("made")}
    with closing(imported(folder / "two", folder / "out")) as again:
        second = {label.id: label for label in again.palette("again")}
        for index, (frame, label) in enumerate(zip(frames, labels, strict=True)):
            np.testing.assert_array_equal(again.annotation("again", index)[0], label)
            provenance = again.annotation("again", index, "provenance")[0]
            np.testing.assert_array_equal(provenance, np.where(label > 0, 3, 0))
            stored = again.recording("again")[index]
            columns = stored.read_source(0, stored.count, ["xyz", "rgb", "intensity"])
            order = np.argsort(stored.source_index)
            close = {"rtol": 0, "atol": EXACT.get(kind, 0.0)}
            xyz = _world(again, index, columns["xyz"][order])
            if kind == "csv":
                xyz = xyz.astype(frame.xyz.dtype)  # text has no types
            np.testing.assert_allclose(xyz, frame.xyz, **close)
            np.testing.assert_array_equal(columns["intensity"][order], frame.intensity)
            if kind != "semantickitti":
                np.testing.assert_array_equal(columns["rgb"][order], frame.rgb)
    used = set(np.unique(np.concatenate(labels)).tolist()) - {0}
    for label_id in used:
        ours, theirs = first[label_id], second[label_id]
        assert (theirs.name, theirs.category) == (ours.name, ours.category)
        assert theirs.color == ours.color


def _world(workspace: Workspace, index: int, xyz: np.ndarray) -> np.ndarray:
    """Coordinates of the source: those that a pose has undone are moved back."""
    pose = workspace.recording("again")[index].pose
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
        job = workspace.import_paths([source], chosen=Corrections(drop_invalid=True))
        done = workspace.runner.wait(job.id, PATIENCE)
        assert done.state == "done", done.error
        label = workspace.create_label("scan", "ann", name="a").id
        painted_ = np.zeros(16, np.uint16)
        painted_[[0, 5, 15]] = label
        workspace.put_annotation("scan", 0, painted_, author="ann")
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
        workspace.undo("scan", "ann")
        job = workspace.import_labels("scan", tmp_path / "labels", "bob")
        done = workspace.runner.wait(job.id, PATIENCE)
        assert done.state == "done", done.error
        np.testing.assert_array_equal(workspace.annotation("scan", 0)[0] > 0, painted_ > 0)
