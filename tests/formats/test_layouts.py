"""Whole folders of KITTI and Argoverse, PTX, and layouts for training code, both ways."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import feather

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats import LabeledFrame, Limits, Split, export, open_source
from pointbrush.formats.boxes.registry import is_box_file, read_boxes
from pointbrush.frame import PointFrame
from tests.formats.test_exports import Label


def records(seed: int, count: int = 60) -> np.ndarray:
    rng = np.random.default_rng(seed)
    table = rng.uniform(-30, 30, (count, 4)).astype("<f4")
    table[:, 3] = rng.uniform(0, 1, count)
    return table


def test_a_raw_recording_of_kitti_has_times_and_poses_of_its_unit(tmp_path: Path) -> None:
    drive = tmp_path / "2011_09_26" / "2011_09_26_drive_0001_sync"
    velodyne, oxts = drive / "velodyne_points", drive / "oxts"
    for folder in (velodyne / "data", oxts / "data", drive / "image_02" / "data"):
        folder.mkdir(parents=True)
    stamps = [f"2011-09-26 13:02:25.{1000000 + 100_000_000 * i:09d}" for i in range(3)]
    for folder in (velodyne, oxts):
        (folder / "timestamps.txt").write_text("\n".join(stamps) + "\n")
    for i in range(3):
        (velodyne / "data" / f"{i:010d}.bin").write_bytes(records(i).tobytes())
        # A metre north is 1 / 111,320 of a degree.
        row = [49.0 + i * 2 / 111_320, 8.4, 110.0 + i, 0, 0, np.pi / 2, *([0.0] * 24)]
        (oxts / "data" / f"{i:010d}.txt").write_text(" ".join(map(str, row)))
    (drive.parent / "calib_imu_to_velo.txt").write_text(
        "calib_time: x\nR: 1 0 0 0 1 0 0 0 1\nT: -1 0 0.5\n"
    )
    with open_source([drive]) as source:
        frames = list(source.frames)
        assert source.fps == 10
        assert source.listings[0].poses_from == "oxts"
    assert np.array_equal(frames[1].xyz, records(1)[:, :3])
    poses = [frame.pose for frame in frames]
    assert poses[0] is not None
    assert poses[2] is not None
    assert np.allclose(poses[0], np.eye(4))
    # The unit looks north, so that north is ahead of it.
    assert poses[2][:3, 3] == pytest.approx([4, 0, 2], abs=0.05)
    assert frames[0].timestamp is not None


def test_an_odometry_recording_of_kitti_has_its_poses_in_the_dataset(tmp_path: Path) -> None:
    sequence = tmp_path / "sequences" / "07"
    (sequence / "velodyne").mkdir(parents=True)
    (tmp_path / "poses").mkdir()
    for i in range(2):
        (sequence / "velodyne" / f"{i:06d}.bin").write_bytes(records(i).tobytes())
    (sequence / "calib.txt").write_text("Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n")
    rows = ["1 0 0 0 0 1 0 0 0 0 1 " + str(i) for i in range(2)]
    (tmp_path / "poses" / "07.txt").write_text("\n".join(rows))
    with open_source([sequence]) as source:
        _, second = source.frames
    # Ahead of the camera is the velodyne's x.
    assert second.pose is not None
    assert second.pose[:3, 3] == pytest.approx([1, 0, 0])


def test_a_log_of_argoverse_has_its_poses_and_times(tmp_path: Path) -> None:
    lidar = tmp_path / "sensors" / "lidar"
    lidar.mkdir(parents=True)
    times = [315_966_265_259_836_000 + i * 100_000_000 for i in range(3)]
    for i, time in enumerate(times):
        table = records(i)
        columns = {n: table[:, k].astype(np.float16) for k, n in enumerate("xyz")}
        columns |= {"intensity": np.arange(60, dtype=np.uint8)}
        columns |= {"laser_number": np.arange(60, dtype=np.uint8), "offset_ns": np.arange(60)}
        feather.write_feather(pa.table(columns), lidar / f"{time}.feather")
    place = {"tx_m": [0.0, 2.0, 4.0], "ty_m": [0.0] * 3, "tz_m": [0.0] * 3}
    turn = {"qw": [1.0] * 3, "qx": [0.0] * 3, "qy": [0.0] * 3, "qz": [0.0] * 3}
    feather.write_feather(
        pa.table({"timestamp_ns": times, **turn, **place}),
        tmp_path / "city_SE3_egovehicle.feather",
    )
    # Tables of other things, as logs have them.
    np.savez(tmp_path / "ego_motion.npz", ego_motion=np.eye(4)[None])
    feather.write_feather(pa.table({"flow_tx_m": [0.0]}), tmp_path / "flow_labels.feather")
    with open_source([tmp_path]) as source:
        frames = list(source.frames)
        assert source.fps == 10
    assert frames[2].pose is not None
    assert frames[2].pose[0, 3] == 4
    assert np.array_equal(frames[0].xyz, records(0)[:, :3].astype(np.float16).astype(np.float32))
    assert frames[0].intensity is not None
    assert frames[0].intensity[-1] == 59
    assert set(frames[0].other) == {"laser_number", "offset_ns"}
    with pytest.raises(TooLargeError):
        list(open_source([lidar], limits=Limits(max_points=10)).frames)
    (lidar / f"{times[0]}.feather").write_bytes(b"ARROW1\0\0 and no more")
    with pytest.raises(BadInputError, match="expected a feather table"):
        list(open_source([lidar]).frames)


PTX = """2
2
10 20 1
1 0 0
0 1 0
0 0 1
1 0 0 0
0 1 0 0
0 0 1 0
10 20 1 1
1 2 3 0.5 255 0 0
0 0 0 0.5 0 0 0
0 0 0 0.5 0 0 0
4 5 6 0.25 0 255 0
"""


def test_scans_of_a_ptx_are_frames_with_their_place(tmp_path: Path) -> None:
    (tmp_path / "a.ptx").write_text(PTX + PTX.replace("10 20 1 1", "30 20 1 1"))
    with open_source([tmp_path / "a.ptx"]) as source:
        first, second = source.frames
    assert first.xyz.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert first.rgb is not None
    assert first.rgb.tolist() == [[255, 0, 0], [0, 255, 0]]
    assert first.intensity is not None
    assert first.intensity.tolist() == [0.5, 0.25]
    assert first.dropped == 2
    assert first.pose is not None
    assert first.pose[:3, 3].tolist() == [10, 20, 1]
    assert second.pose is not None
    assert second.pose[0, 3] == 30
    for damaged in (PTX[:-8], PTX.replace("2\n2\n", "2\n900\n", 1), "2\n", "", PTX[4:]):
        (tmp_path / "a.ptx").write_text(damaged)
        with pytest.raises(BadInputError, match=r"a\.ptx"):
            list(open_source([tmp_path / "a.ptx"]).frames)


# ── for training ─────────────────────────────────────────────────────────────────────────────


def labelled(index: int, count: int = 400, recording: str = "drive") -> LabeledFrame:
    """A car of 4 x 2 x 1.5 m on a floor; the first points are deleted."""
    rng = np.random.default_rng(index)
    floor = rng.uniform([-20, -20, 0], [20, 20, 0.01], (count - 200, 3))
    car = rng.uniform([-2, -1, 0.2], [2, 1, 1.7], (200, 3)) + [5, index, 0]
    label = np.concatenate([np.zeros(count - 200), np.full(200, 7)]).astype(np.uint16)
    deleted = np.zeros(count, np.bool_)
    deleted[:3] = True
    frame = PointFrame(
        np.concatenate([floor, car]),
        rgb=rng.integers(0, 255, (count, 3)).astype(np.uint8),
        intensity=rng.uniform(0, 1, count).astype(np.float32),
    )
    return LabeledFrame(index, frame, label, np.ones(count, np.uint8), deleted, recording=recording)


PALETTE = [Label(7, "car 1", "car"), Label(9, "Ada", "a person")]


def test_pointcept_scenes_load_as_its_default_dataset_does(tmp_path: Path) -> None:
    export("pointcept", (labelled(i) for i in range(6)), PALETTE, tmp_path / "out")
    scenes = sorted((tmp_path / "out" / "train").iterdir())
    assert [scene.name for scene in scenes] == [f"drive_{i:06d}" for i in range(6)]
    # What DefaultDataset.get_data does with a scene's folder.
    data = {path.stem: np.load(path) for path in scenes[0].glob("*.npy")}
    count = len(data["coord"])
    assert count == 397
    assert (data["coord"].dtype, data["coord"].shape) == (np.float32, (count, 3))
    assert data["color"].astype(np.float32).shape == (count, 3)
    assert data["strength"].astype(np.float32).shape == (count, 1)
    segment = data["segment"].reshape([-1]).astype(np.int32)
    instance = data["instance"].reshape([-1]).astype(np.int32)
    assert set(segment.tolist()) == {-1, 0}
    assert set(instance[segment == 0].tolist()) == {7}
    assert (instance[segment == -1] == -1).all()


def test_openpcdet_loads_points_boxes_and_splits(tmp_path: Path) -> None:
    export("openpcdet", (labelled(i) for i in range(6)), PALETTE, tmp_path / "out")
    root = tmp_path / "out"
    # What CustomDataset.get_lidar, get_label and set_split do.
    stems = [line.strip() for line in (root / "ImageSets" / "train.txt").read_text().split("\n")]
    assert [stem for stem in stems if stem] == [f"drive_{i:06d}" for i in range(6)]
    points = np.load(root / "points" / "drive_000002.npy")
    assert (points.dtype, points.shape) == (np.float32, (397, 4))
    boxes, names = [], []
    for line in (root / "labels" / "drive_000002.txt").read_text().splitlines():
        *numbers, name = line.strip().split(" ")
        boxes.append(numbers)
        names.append(name)
    (box,) = np.array(boxes, np.float32)
    assert names == ["car"]
    assert box[:3] == pytest.approx([5, 2, 0.95], abs=0.1)
    assert box[3:6] == pytest.approx([4, 2, 1.5], abs=0.1)
    assert abs(np.sin(box[6])) < 0.05
    inside = (np.abs(points[:, :3] - box[:3]) <= box[3:6] / 2 + 0.1).all(axis=1)
    assert inside.sum() >= 200


@pytest.mark.parametrize("format", ["pointcept", "openpcdet"])
def test_scenes_for_training_lie_in_their_split_under_names_of_their_own(
    tmp_path: Path, format: str
) -> None:
    scenes: list[str] = []
    for recording in ("a", "b"):
        split, out = Split(range(2, 4), "frames 2:4"), tmp_path / recording
        frames = (replace(labelled(i, recording=recording), split=split) for i in range(6))
        export(format, frames, PALETTE, out)
        told = json.loads((out / "export.json").read_text())["split"]
        assert told.pop("by") == "frames 2:4"
        for name, expected in (("train", {0, 1, 4, 5}), ("val", {2, 3})):
            listed = out / "ImageSets" / f"{name}.txt"
            found = listed.read_text().split() if listed.exists() else _names(out / name)
            assert sorted(found) == told[name] == [f"{recording}_{i:06d}" for i in sorted(expected)]
            scenes += found
    assert len(set(scenes)) == len(scenes)


def _names(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir()] if folder.is_dir() else []


CAMERA = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])
"""R_source_upright of a camera: x right, y down, z ahead."""
UTM = np.array([388_096.0, 5_948_996.0, 40.0])


@pytest.mark.parametrize("format", ["pointcept", "openpcdet"])
@pytest.mark.parametrize("camera", [False, True])
def test_points_for_training_are_near_and_their_file_tells_the_way_back(
    tmp_path: Path, format: str, camera: bool
) -> None:
    made = labelled(2)
    turn = CAMERA if camera else np.eye(3)
    xyz = made.points.xyz @ turn.T + UTM
    points = replace(made.points, xyz=xyz)
    export(format, [replace(made, points=points, up=turn[:, 2])], PALETTE, tmp_path / "out")
    told = json.loads((tmp_path / "out" / "export.json").read_text())
    T_export_source = np.array(told["T_export_source"])
    (path,) = (tmp_path / "out").rglob("coord.npy" if format == "pointcept" else "points/*.npy")
    got = np.load(path)[:, :3].astype(np.float64)
    kept = xyz[~made.deleted]
    assert np.abs(got - got[0] - (kept - kept[0]) @ T_export_source[:3, :3].T).max() < 0.002
    back = (got - T_export_source[:3, 3]) @ T_export_source[:3, :3]
    assert np.abs(back - kept).max() < 0.002
    if format == "openpcdet":  # x ahead, z up, whatever the source's axes
        expected = made.points.xyz[~made.deleted]
        assert np.abs(got - got[0] - (expected - expected[0])).max() < 0.002


def test_tracklets_of_a_raw_recording_are_boxes_on_their_bottom(tmp_path: Path) -> None:
    poses = "".join(
        f"<item><tx>{10 + i}</tx><ty>2</ty><tz>-1</tz><rx>0</rx><ry>0</ry><rz>1.5</rz></item>"
        for i in range(2)
    )
    path = tmp_path / "tracklet_labels.xml"
    path.write_text(
        "<boost_serialization><tracklets><count>1</count><item><objectType>Car</objectType>"
        "<h>1.6</h><w>1.8</w><l>4</l><first_frame>3</first_frame>"
        f"<poses><count>2</count>{poses}</poses></item></tracklets></boost_serialization>"
    )
    assert is_box_file(path, "kitti-tracklets")
    first, second = read_boxes(path, "kitti-tracklets")
    assert (first.frame, second.frame) == (3, 4)
    (box,) = second.boxes
    assert (box.name, box.key, box.size.tolist()) == ("Car", "1", [4, 1.8, 1.6])
    assert box.center == pytest.approx([11, 2, -0.2])
    assert box.rotation[:2, 0] == pytest.approx([np.cos(1.5), np.sin(1.5)])
    path.write_text("<!DOCTYPE a [<!ENTITY b 'c'>]><tracklets/>")
    with pytest.raises(BadInputError, match="entities"):
        read_boxes(path, "kitti-tracklets")
