"""Exports, read back by independent readers; whole or not at all."""

from __future__ import annotations

import errno
import io
import json
import zipfile
from dataclasses import dataclass

import laspy
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plyfile import PlyData

from pointbrush.errors import BadInputError, UnavailableError
from pointbrush.formats import EXPORTS, LabeledFrame, export, read
from pointbrush.formats.readers.kitti import pack_label
from pointbrush.formats.writers.boxes import pca_box, upright_axes, upright_box
from pointbrush.frame import PointFrame


@dataclass
class Label:
    id: int
    name: str
    category: str
    color: str = "#ff8800"
    instance: int | None = None


PALETTE = [Label(1, "pin 1", "pin"), Label(3, "pin 2", "pin"), Label(7, "Ännä / ..", "")]
COUNT, DELETED = 60, 4


def frames(number=2, dtype=np.float64):
    rng = np.random.default_rng(11)
    for index in range(number):
        label = rng.choice(np.array([0, 1, 3, 7], np.uint16), COUNT)
        deleted = np.zeros(COUNT, bool)
        deleted[:DELETED] = True
        yield LabeledFrame(
            index=index,
            points=PointFrame(
                xyz=(rng.normal(size=(COUNT, 3)) + [4e5, 5e6, 100]).astype(dtype),
                rgb=rng.integers(0, 256, (COUNT, 3), dtype=np.uint8),
                intensity=rng.random(COUNT).astype(np.float32),
                pose=np.eye(4),
                timestamp=index / 10,
            ),
            label=label,
            provenance=(label > 0).astype(np.uint8),
            deleted=deleted,
            tracks=[{"label": 1, "frame": index, "confidence": 0.5}],
        )


def test_ply_in_source_order_without_deleted_points(tmp_path):
    export("ply", frames(), PALETTE, tmp_path / "out")
    for frame in frames():
        vertex = PlyData.read(tmp_path / "out" / f"{frame.index:06d}.ply")["vertex"]
        assert vertex.data.dtype.names == (
            *("x", "y", "z", "red", "green", "blue"),
            *("intensity", "label", "category", "instance"),
        )
        assert vertex["x"].tobytes() == frame.points.xyz[DELETED:, 0].tobytes()
        assert np.array_equal(vertex["label"], frame.label[DELETED:])
        numbers = {0: (0, 0), 1: (1, 1), 3: (1, 2), 7: (2, 1)}
        pairs = [numbers[label] for label in frame.label[DELETED:].tolist()]
        assert list(zip(vertex["category"], vertex["instance"], strict=True)) == pairs
        assert np.array_equal(vertex["blue"], frame.points.rgb[DELETED:, 2])
    palette = json.loads((tmp_path / "out" / "palette.json").read_text())
    assert [label["category_id"] for label in palette["labels"]] == [1, 1, 2]
    assert palette["labels"][2] == {
        **{"id": 7, "name": "Ännä / ..", "category": "Ännä / ..", "category_id": 2},
        **{"instance": 1, "color": "#ff8800", "datasets": {"semantickitti": [2, 7]}},
        **{"source_instance": None, "categoryless": True},
    }


def test_npz_has_the_mask_of_what_was_left_out(tmp_path):
    export("npz", frames(1), PALETTE, tmp_path / "a.npz")
    (frame,) = frames(1)
    with np.load(tmp_path / "a.npz") as arrays:
        assert np.array_equal(arrays["xyz"], frame.points.xyz[~arrays["deleted"]])
        assert np.array_equal(arrays["label"], frame.label[DELETED:])
        assert np.array_equal(arrays["provenance"], frame.provenance[DELETED:])
        assert len(arrays["deleted"]) == COUNT
    assert (tmp_path / "a.palette.json").is_file()


def test_semantickitti_bits_and_layout(tmp_path):
    export("semantickitti", frames(), PALETTE, tmp_path / "out")
    root = tmp_path / "out" / "sequences" / "00"
    for frame in frames():
        points = np.fromfile(root / "velodyne" / f"{frame.stem}.bin", "<f4").reshape(-1, 4)
        label = np.fromfile(root / "labels" / f"{frame.stem}.label", "<u4")
        assert len(points) == len(label) == COUNT - DELETED
        assert np.array_equal(label >> 16, frame.label[DELETED:])
        # No class but SemanticKITTI's outlier has its number 1.
        category = {0: 0, 1: 65535, 3: 65535, 7: 2}
        assert (label & 0xFFFF).tolist() == [category[v] for v in frame.label[DELETED:].tolist()]
    back = list(read(tmp_path / "out"))
    assert [frame.timestamp for frame in back] == [0.0, 0.1]
    for frame, original in zip(back, frames(), strict=True):
        assert np.array_equal(frame.label, original.label[DELETED:])
        # Far from the origin the pose carries what float32 could not.
        world = frame.xyz.astype(float) @ frame.pose[:3, :3].T + frame.pose[:3, 3]
        assert np.abs(world - original.points.xyz[DELETED:]).max() < 1e-6


def test_near_coordinates_and_poses_stay_as_they_are_in_semantickitti(tmp_path):
    near = PointFrame(xyz=np.random.default_rng(0).normal(size=(9, 3)), pose=np.eye(4))
    zeros = np.zeros(9, np.uint16), np.zeros(9, np.uint8), np.zeros(9, bool)
    export("semantickitti", [LabeledFrame(5, near, *zeros)], PALETTE, tmp_path / "out")
    (frame,) = read(tmp_path / "out")
    assert np.array_equal(frame.xyz, near.xyz.astype(np.float32))
    assert frame.pose.tolist() == np.eye(4).tolist()


@pytest.mark.parametrize("place", [0, 5e6])
def test_a_frame_without_a_pose_keeps_none_in_semantickitti(tmp_path, place):
    zeros = np.zeros(9, np.uint16), np.zeros(9, np.uint8), np.zeros(9, bool)
    xyz = np.random.default_rng(0).normal(size=(9, 3)) + place
    poses = [np.eye(4), None, np.diag([-1.0, -1.0, 1.0, 1.0])]
    written = [LabeledFrame(k, PointFrame(xyz, pose=p), *zeros) for k, p in enumerate(poses)]
    export("semantickitti", written, PALETTE, tmp_path / "out")
    assert [frame.pose is None for frame in read(tmp_path / "out")] == [False, True, False]


@given(st.lists(st.tuples(st.integers(0, 65535), st.integers(0, 65535)), min_size=1))
def test_label_bit_layout(pairs):
    semantic, instance = np.array(pairs, np.uint16).T
    packed = pack_label(semantic, instance)
    assert packed.dtype == np.dtype("<u4")
    assert packed.tolist() == [instance * 65536 + semantic for semantic, instance in pairs]
    low_first = packed.tobytes()
    assert low_first[0] == pairs[0][0] & 255
    assert low_first[3] == pairs[0][1] >> 8


def test_labels_only_has_one_entry_per_source_point(tmp_path):
    export("labels-only", frames(), PALETTE, tmp_path / "out")
    (frame, _) = frames()
    label = np.load(tmp_path / "out" / "label" / "000000.npy")
    assert label.dtype == np.uint16
    assert label[:DELETED].tolist() == [0] * DELETED
    assert np.array_equal(label[DELETED:], frame.label[DELETED:])
    assert np.array_equal(np.load(tmp_path / "out" / "deleted" / "000000.npy"), frame.deleted)


@pytest.mark.parametrize("ending", ["las", "laz", "pcd", "csv"])
def test_other_point_formats_read_back(tmp_path, ending):
    export(ending, frames(), PALETTE, tmp_path / "out")
    back = list(read(tmp_path / "out" / f"*.{ending}"))
    for frame, original in zip(back, frames(), strict=True):
        assert np.abs(frame.xyz - original.points.xyz[DELETED:]).max() < 1e-8
        assert np.array_equal(frame.label, original.label[DELETED:])
        assert np.array_equal(frame.rgb, original.points.rgb[DELETED:])
    if ending == "las":
        assert laspy.read(tmp_path / "out" / "000001.las")["instance"].max() == 2


def test_cut_writes_each_label_as_its_own_file(tmp_path):
    export("cut", frames(), PALETTE, tmp_path / "out")
    folders = sorted(path.name for path in (tmp_path / "out").iterdir() if path.is_dir())
    assert folders == ["00001_pin-1", "00003_pin-2", "00007_nn"]
    (frame, _) = frames()
    vertex = PlyData.read(tmp_path / "out" / "00003_pin-2" / "000000.ply")["vertex"]
    assert vertex.count == np.count_nonzero((frame.label == 3) & ~frame.deleted)
    assert set(vertex["label"]) == {3}


def test_boxes_hold_their_points(tmp_path):
    export("boxes", frames(), PALETTE, tmp_path / "out")
    boxes = json.loads((tmp_path / "out" / "boxes.json").read_text())["boxes"]
    assert len(boxes) == 6
    all_frames = list(frames())
    for record in boxes:
        frame = all_frames[record["frame"]]
        xyz = frame.points.xyz[(frame.label == record["label"]) & ~frame.deleted]
        assert record["points"] == len(xyz)
        for box in (record["box"], record["upright"]):
            local = (xyz - box["center"]) @ np.array(box["rotation"])
            assert (np.abs(local) <= np.array(box["size"]) / 2 + 1e-6).all()
    lines = (tmp_path / "out" / "label_02" / "0000.txt").read_text().splitlines()
    assert [len(line.split()) for line in lines] == [17] * 6
    assert lines[0].split()[:3] == ["0", "1", "pin"]
    assert boxes[0]["track"]["confidence"] == 0.5


@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 40),
    st.sampled_from([(1, 1, 1), (3, 1, 0), (1, 0, 0), (0, 0, 0)]),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
)
def test_fitted_boxes_contain_and_are_proper_rotations(seed, count, spread, up):
    points = np.random.default_rng(seed).normal(size=(count, 3)) * spread + 5
    up = np.array(up) / np.linalg.norm(up)
    for box in (pca_box(points), upright_box(points, up)):
        assert np.allclose(box.R.T @ box.R, np.eye(3), atol=1e-9)
        assert np.linalg.det(box.R) == pytest.approx(1)
        local = (points - box.center) @ box.R
        assert (np.abs(local) <= box.size / 2 + 1e-9).all()
    assert np.allclose(upright_box(points, up).R[:, 2], up)
    assert np.linalg.det(upright_axes(up)) == pytest.approx(1)


def test_a_turned_rectangle_is_found():
    grid = np.stack(np.meshgrid([-2, 0, 2], [-0.5, 0.5], [0, 1]), -1).reshape(-1, 3)
    turn = np.deg2rad(30)
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    box = upright_box(grid @ R.T, np.array([0, 0, 1]))
    assert box.size == pytest.approx([4, 1, 1])
    assert box.yaw == pytest.approx(turn)
    assert box.center == pytest.approx([0, 0, 0.5])


@pytest.mark.parametrize("name", EXPORTS)
def test_folder_zip_and_stream_hold_the_same(tmp_path, name):
    export(name, frames(), PALETTE, tmp_path / "out")
    export(name, frames(), PALETTE, tmp_path / "out.zip")
    stream = io.BytesIO()
    export(name, frames(), PALETTE, stream)
    folder = {
        path.relative_to(tmp_path / "out").as_posix()
        for path in (tmp_path / "out").rglob("*")
        if path.is_file()
    }
    assert "palette.json" in folder
    for archive in (tmp_path / "out.zip", stream):
        with zipfile.ZipFile(archive) as opened:
            assert set(opened.namelist()) == folder
            assert opened.testzip() is None
    assert {path.name for path in tmp_path.iterdir()} == {"out", "out.zip"}


def failing():
    yield from frames(1)
    raise RuntimeError("away")


@pytest.mark.parametrize("out", ["out", "out.zip", "out.ply"])
def test_nothing_is_left_when_frames_fail(tmp_path, out):
    with pytest.raises(RuntimeError, match="away"):
        export("ply", failing(), PALETTE, tmp_path / out)
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_written_says_so(tmp_path):
    with pytest.raises(BadInputError, match="format: expected one of ply"):
        export("mp3", frames(), PALETTE, tmp_path / "a")
    with pytest.raises(BadInputError, match="more than one frame"):
        export("ply", frames(2), PALETTE, tmp_path / "a.ply")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").write_text("keep")
    with pytest.raises(BadInputError, match="new or an empty folder"):
        export("ply", frames(), PALETTE, tmp_path / "full")
    assert [path.name for path in tmp_path.iterdir()] == ["full"]
    frame = next(frames())
    with pytest.raises(BadInputError, match="expected 60 labels"):
        LabeledFrame(0, frame.points, frame.label[:3], frame.provenance, frame.deleted)


def full():
    yield from frames(1)
    raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize("out", ["out", "out.zip", "out.ply"])
def test_a_full_disk_says_so_and_leaves_nothing(tmp_path, out):
    with pytest.raises(UnavailableError, match="disk is full"):
        export("ply", full(), PALETTE, tmp_path / out)
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_says_so(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(BadInputError, match="out: expected a place to write"):
        export("ply", frames(1), PALETTE, tmp_path / "file" / "out")
