"""Recordings of several sensors: from bags, folders and data sets, joined by time."""

from __future__ import annotations

import json
import shutil
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image
from pyarrow import feather
from scipy.spatial.transform import Rotation

from pointbrush.errors import BadInputError, ForbiddenError, NotFoundError
from pointbrush.formats import Limits, open_source, reported
from pointbrush.formats.sensors.clocks import clock_offset
from pointbrush.formats.sensors.joining import joined_frames
from pointbrush.formats.tables.corrections import Corrections, parse_corrections
from pointbrush.frame import PointFrame, Sensor, frame_of_part, to_frame
from tests.formats.test_bags import Writer
from tests.formats.test_pictures import nuscenes, rosbag1, transform_message

Matrix = NDArray[np.float64]


def mount(x: float, degrees: float = 90.0) -> Matrix:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("zyx", [degrees, 10, 5], degrees=True).as_matrix()
    T[:3, 3] = x, 0.25, 1.5
    return T


def frames_of(*paths: Path, **options: Any) -> list[PointFrame]:
    with open_source(paths or [Path()], chosen=parse_corrections(options)) as source:
        frames = list(source.frames)
        assert len(frames) == source.count == len(source.origins)
    return frames


def require_same(joined: PointFrame, number: int, alone: PointFrame) -> None:
    """Require that a sensor's points and fields are bit for bit those of its own recording."""
    part = next(part for part in joined.parts if part.sensor == number)
    own = frame_of_part(joined, part)
    for name in ("xyz", "rgb", "intensity", "pixel"):
        expected, got = getattr(alone, name), getattr(own, name)
        assert (expected is None) == (got is None), name
        assert expected is None or np.array_equal(expected, got), name
    assert own.xyz.dtype == alone.xyz.dtype
    assert own.timestamp == alone.timestamp
    assert all(np.array_equal(own.other[name], values) for name, values in alone.other.items())
    rows = joined.sensor == number
    assert np.array_equal(
        joined.xyz[rows], to_frame(alone.xyz, part.T_frame_sensor, joined.xyz.dtype)
    )


# ── joining by time ──────────────────────────────────────────────────────────────────────────

TIMES = st.lists(st.integers(0, 400), unique=True, max_size=12).map(
    lambda found: [each / 16 for each in sorted(found)]
)


@given(TIMES, TIMES)
def test_frames_join_their_nearest_within_half_a_period_and_once(
    reference: list[float], times: list[float]
) -> None:
    found = joined_frames(reference, times)
    assert len(found) == len(reference)
    joined = [frame for frame in found if frame is not None]
    assert joined == sorted(set(joined))
    for steps in (np.diff(reference), np.diff(times), np.array([np.inf])):
        if len(steps):
            limit = float(np.median(steps)) / 2
            break
    for frame, time in enumerate(times):
        apart = [abs(time - at) for at in reference]
        near = min(apart, default=np.nan)
        if frame in joined:
            assert apart[found.index(frame)] == near <= limit
        elif near <= limit:
            # Another frame of the sensor is at least as near to the same one of the reference.
            other = found[apart.index(near)]
            assert other is not None
            assert abs(times[other] - reference[apart.index(near)]) <= near


# ── bags ─────────────────────────────────────────────────────────────────────────────────────


def cloud_message(frame_id: str, seconds: float, seed: int, count: int) -> bytes:
    out = Writer(cdr=False)
    out.header(seconds, frame_id)
    out.number("I", 1)
    out.number("I", count)
    out.number("I", 4)
    for k, name in enumerate(("x", "y", "z", "intensity")):
        out.text(name)
        out.number("I", 4 * k)
        out.number("B", 7)
        out.number("I", 1)
    out.number("B", 0)
    out.number("I", 16)
    out.number("I", 16 * count)
    data = np.random.default_rng(seed).uniform(1, 30, (count, 4)).astype("<f4").tobytes()
    out.number("I", len(data))
    return out.out + data + b"\1"


FRONT, REAR, SLOW = "/front/points", "/rear/points", "/radar/points"


def two_lidars(folder: Path, *, static: bool = True, late: float = 0.01) -> Path:
    """Five clouds of a lidar, four of another, and one of a third topic."""
    kind, rows = "sensor_msgs/PointCloud2", []
    links = (("base", "front", (1.0, 0, 0)), ("base", "rear", (-2.0, 0, 0.5)))
    if static:
        rows.append(("/tf_static", "tf2_msgs/TFMessage", 0.0, transform_message(*links)))
    for k in range(5):
        at = 100 + k / 8
        rows.append((FRONT, kind, at, cloud_message("front", at, k, 30)))
        if k < 4:
            rows.append((REAR, kind, at, cloud_message("rear", at + late, 50 + k, 20)))
    rows.append((SLOW, kind, 101.0, cloud_message("radar", 101.0, 9, 5)))
    path = folder / "drive.bag"
    path.write_bytes(rosbag1(*rows))
    return path


@pytest.mark.parametrize(
    "options", [{"topic": [FRONT, REAR]}, {"topic": f"{FRONT}, {REAR}"}, {"sensors": "all"}]
)
def test_two_lidars_of_a_bag_are_one_recording(tmp_path: Path, options: dict[str, Any]) -> None:
    path = two_lidars(tmp_path)
    with reported() as warnings:
        frames = frames_of(path, **options)
    assert frames[0].sensors == (Sensor("front"), Sensor("rear"))
    assert [len(frame.parts) for frame in frames] == [2, 2, 2, 2, 1]
    for number, topic in enumerate((FRONT, REAR)):
        for frame, alone in zip(frames, frames_of(path, topic=topic), strict=False):
            require_same(frame, number, alone)
    # The frame has the coordinates of the first topic; the rear lidar is 3 m behind.
    assert frames[0].parts[0].T_frame_sensor.tolist() == np.eye(4).tolist()
    assert frames[0].parts[1].T_frame_sensor[:3, 3].tolist() == [-3, 0, 0.5]
    assert any("1 of 5 frames have no points of rear" in warning for warning in warnings)
    assert ("another rate" in "".join(warnings)) == ("sensors" in options)


def test_a_bag_of_one_topic_reads_as_before(tmp_path: Path) -> None:
    assert all(frame.sensor is None for frame in frames_of(two_lidars(tmp_path)))


def test_sensors_of_a_bag_need_a_mount_that_is_one(tmp_path: Path) -> None:
    path, given_mounts = two_lidars(tmp_path, static=False), tmp_path / "rig.json"
    with pytest.raises(BadInputError, match=r"connect rear \(rear\) with front"):
        frames_of(path, sensors="all")
    T = mount(-2.0)
    given_mounts.write_text(
        json.dumps({
            "front": {"T_frame_sensor": np.eye(4).tolist(), "type": "spinning"},
            "rear": {"T_frame_sensor": T.ravel().tolist(), "clock_offset_s": -0.01},
        })
    )  # fmt: skip
    frame = frames_of(path, sensors="all", extrinsics=str(given_mounts))[0]
    assert frame.sensors == (Sensor("front", "spinning"), Sensor("rear"))
    assert np.array_equal(frame.parts[1].T_frame_sensor, T)
    assert frame.parts[1].timestamp == pytest.approx(100, abs=1e-9)
    wrong = {"scales": np.diag([1, 1, 1.1, 1]), "left-handed": np.diag([1, -1, 1, 1]),
             "last row": np.eye(4) + np.eye(4, k=-3), "16 numbers": np.eye(3)}  # fmt: skip
    for said, matrix in wrong.items():
        given_mounts.write_text(json.dumps({"front": {"T_frame_sensor": matrix.tolist()}}))
        with pytest.raises(BadInputError, match=f"rig.json: front: T_frame_sensor: .*{said}"):
            frames_of(path, sensors="all", extrinsics=str(given_mounts))


def test_clocks_that_differ_are_refused_with_an_estimate(tmp_path: Path) -> None:
    path = two_lidars(tmp_path, late=1000.0)
    with pytest.raises(BadInputError, match=r"--clock-offset rear=-1000\.000"):
        frames_of(path, sensors="all")
    frames = frames_of(path, sensors="all", clock_offset=["rear=-1000"])
    assert [len(frame.parts) for frame in frames] == [2, 2, 2, 2, 1]
    with pytest.raises(BadInputError, match="expected one of the sensors front, rear, got 'left'"):
        frames_of(path, sensors="all", clock_offset=["left=1"])


def seen(times: Sequence[float], seed: int, T: Matrix) -> list[NDArray[np.float32]]:
    """A ball that moves irregularly over a floor, as a sensor sees it at some times."""
    rng = np.random.default_rng(seed)
    floor = rng.uniform([-3, -3, 0], [3, 3, 0.02], (1500, 3))
    found = []
    for t in times:
        way = [1.2 * np.sin(0.9 * t + 0.3 * np.sin(2.3 * t)), 0.5 * np.cos(1.7 * t) ** 3, 1.2]
        ball = rng.normal(size=(400, 3))
        ball = 0.3 * ball / np.linalg.norm(ball, axis=1, keepdims=True) + way
        points = np.concatenate([floor + rng.normal(0, 0.004, floor.shape), ball])
        found.append((points @ T[:3, :3].T + T[:3, 3]).astype(np.float32))
    return found


def test_a_clock_offset_is_estimated_from_motion(tmp_path: Path) -> None:
    late, names = 12.5, ("a", "b")
    clocks = {"a": np.arange(60) / 10, "b": np.arange(60) / 10 + 0.03}
    for name, times in clocks.items():
        (tmp_path / name).mkdir()
        for k, points in enumerate(seen(times, ord(name), mount(0))):
            np.save(tmp_path / name / f"{k:03d}.npy", points)
        told = times - (late if name == "b" else 0)
        (tmp_path / name / "times.txt").write_text("".join(f"{each}\n" for each in told))
    file = tmp_path / "extrinsics.json"
    file.write_text(json.dumps({n: {"T_frame_sensor": np.eye(4).tolist()} for n in names}))
    with pytest.raises(BadInputError, match="expected frames at the times of a"):
        frames_of(tmp_path)
    with reported() as warnings:
        frames = frames_of(tmp_path, clock_offset=["b=auto"])
    assert any("estimated from motion" in warning for warning in warnings)
    apart = [f.parts[1].timestamp - f.parts[0].timestamp for f in frames if len(f.parts) > 1]
    assert len(apart) == 60
    assert apart == pytest.approx([0.03] * 60, abs=0.03)
    for path in sorted((tmp_path / "b").glob("*.npy")):
        np.save(path, seen([0.0], int(path.stem), np.eye(4))[0])
    with pytest.raises(BadInputError, match="expected motion that a sees as well"):
        frames_of(tmp_path, clock_offset=["b=auto"])
    (tmp_path / "b" / "times.txt").unlink()
    with pytest.raises(BadInputError, match="b: expected times of its frames"):
        frames_of(tmp_path, clock_offset=["b=auto"])


def test_noise_and_broken_clocks_give_no_clock_offset() -> None:
    rng, times = np.random.default_rng(4), np.arange(15) / 10
    for _ in range(100):
        first, second = rng.normal(1, 0.1, (2, 14))
        assert not clock_offset(first, times, second, times).is_clear
    gap = np.append(times[:-1], 1e9)
    for broken in (np.zeros(15), gap):
        assert not clock_offset(first, broken, second, times).is_clear


# ── folders ──────────────────────────────────────────────────────────────────────────────────


def depth_folder(folder: Path, seed: int, times: Sequence[float]) -> Path:
    """Depth and colour images in the layout of the TUM benchmark."""
    rng, lines = np.random.default_rng(seed), []
    for name in ("depth", "rgb"):
        (folder / name).mkdir(parents=True)
    for time in times:
        depth = rng.integers(5000, 15000, (24, 32)).astype(np.uint16)
        depth[rng.random(depth.shape) < 0.1] = 0
        Image.fromarray(depth).save(folder / "depth" / f"{time:.4f}.png")
        Image.fromarray(rng.integers(0, 255, (24, 32, 3), np.uint8)).save(
            folder / "rgb" / f"{time:.4f}.png"
        )
        lines.append(f"{time:.4f} {{0}}/{time:.4f}.png\n")
    for name in ("depth", "rgb"):
        (folder / f"{name}.txt").write_text("".join(lines).format(name))
    camera = {"fx": 30.0 + seed, "fy": 30.0, "cx": 15.5, "cy": 11.5, "depth_scale": 5000}
    (folder / "camera.json").write_text(json.dumps(camera))
    return folder


def rig(folder: Path) -> dict[str, Path]:
    """Three depth cameras; frames of the last one begin a frame later."""
    starts = {"left": 10.0, "middle": 10.005, "right": 10.12}
    return {
        name: depth_folder(folder / name, seed, [start + k / 8 for k in range(4)])
        for seed, (name, start) in enumerate(starts.items())
    }


EYE = np.eye(4).ravel().tolist()
MOUNTS = {"left": mount(-1.0, 60), "middle": mount(0.0, 0), "right": mount(1.0, -60)}


@pytest.mark.parametrize("how", ["named", "json", "calib", "zip"])
def test_three_depth_folders_are_one_recording(tmp_path: Path, how: str) -> None:
    top = tmp_path / "rig"
    places = rig(top)
    document = {name: {"T_frame_sensor": T.tolist()} for name, T in MOUNTS.items()}
    text = "".join(
        f"{n}: {' '.join(map(repr, T[:3].ravel().tolist()))}\n" for n, T in MOUNTS.items()
    )
    options: dict[str, Any] = {}
    if how == "calib":
        (top / "calib.txt").write_text(text)
    else:
        file = top / ("my.json" if how == "named" else "extrinsics.json")
        file.write_text(json.dumps(document))
    if how == "zip":
        source = Path(shutil.make_archive(str(tmp_path / "rig"), "zip", tmp_path, "rig"))
    else:
        source = top
    if how == "named":
        options = {"sensor": [f"{n}={p}" for n, p in places.items()], "extrinsics": str(file)}
    with reported() as warnings:
        frames = frames_of(source, **options)
    assert frames[0].sensors == tuple(Sensor(name, "depth") for name in places)
    assert [[part.sensor for part in frame.parts] for frame in frames] == [
        [0, 1], [0, 1, 2], [0, 1, 2], [0, 1, 2]
    ]  # fmt: skip
    for number, (name, place) in enumerate(places.items()):
        own = frames_of(place)
        for frame in frames[1:]:
            part = frame.parts[number]
            alone = next(each for each in own if each.timestamp == part.timestamp)
            require_same(frame, number, alone)
            assert part.camera is not None
            assert part.camera.fx == 30 + number
            assert np.allclose(part.T_frame_sensor, MOUNTS[name])
    assert any(
        "right: 1 of 4 frames are left out: no frame of left" in warning for warning in warnings
    )


def test_the_pose_of_the_reference_sensor_is_the_rigs(tmp_path: Path) -> None:
    places = rig(tmp_path)
    moves = [f"{10 + k / 8:.4f} {k} 0 0 0 0 0 1\n" for k in range(4)]
    (places["left"] / "groundtruth.txt").write_text("".join(moves))
    file = tmp_path / "extrinsics.json"
    file.write_text(json.dumps({n: {"T_frame_sensor": T.tolist()} for n, T in MOUNTS.items()}))
    for k, frame in enumerate(frames_of(tmp_path)):
        assert frame.pose is not None
        T_world_left = frame.pose @ frame.parts[0].T_frame_sensor
        expected = np.eye(4)
        expected[0, 3] = k
        assert np.allclose(T_world_left, expected)


def test_sensors_that_make_no_recording_are_refused_in_words(tmp_path: Path) -> None:
    places = rig(tmp_path)
    file = tmp_path / "my.json"
    file.write_text(json.dumps({n: {"T_frame_sensor": T.tolist()} for n, T in MOUNTS.items()}))
    named = [f"{name}={path}" for name, path in places.items()]
    for sensor, said in (
        ([*named, named[0]], "each sensor once, got 'left' twice"),
        ([named[0], f"top={places['right']}"], "top: expected the mount of the sensor"),
        ([named[0]], "expected two sensors or more"),
        (["left"], "expected NAME=VALUE"),
        ([named[0], f"right={tmp_path / 'nowhere'}"], "there is no nowhere"),
        (["caf\u00e9=a", "cafe\u0301=b"], "each sensor once"),
    ):
        with pytest.raises((BadInputError, NotFoundError), match=said):
            frames_of(tmp_path, sensor=sensor, extrinsics=str(file))
    for entry, said in (
        ({}, "expected T_frame_sensor, got nothing"),
        ({"T_frame_sensor": [1, 2]}, r"left: T_frame_sensor: expected 16 numbers.*got \[1, 2\]"),
        ({"T_frame_sensor": [1e300] * 16}, r"expected numbers up to 1e\+12"),
        ({"T_frame_sensor": [float("nan")] * 16}, "expected numbers up to"),
        ({"T_frame_sensor": EYE, "clock_offset_s": True}, "expected seconds"),
        ({"T_frame_sensor": EYE, "clock_offset_s": 1e308}, "expected seconds up to"),
    ):
        (tmp_path / "extrinsics.json").write_text(json.dumps({"left": entry}))
        with pytest.raises(BadInputError, match=said):
            frames_of(tmp_path)
    file.write_text(" " * 2_000_000)
    with pytest.raises(BadInputError, match=r"my\.json: expected at most 1,048,576 bytes"):
        frames_of(tmp_path, extrinsics=str(file))


@pytest.mark.parametrize("name", ["x" * 201, "camera \u00e9"], ids=["long", "accent"])
def test_names_of_sensors_are_limited_and_composed(tmp_path: Path, name: str) -> None:
    for seed, folder in enumerate(("left", unicodedata.normalize("NFD", name)[:200])):
        depth_folder(tmp_path / folder, seed, [10.0])
    known = {each: {"T_frame_sensor": EYE} for each in ("left", name)}
    (tmp_path / "extrinsics.json").write_text(json.dumps(known))
    if len(name) < 200:
        assert [each.name for each in frames_of(tmp_path)[0].sensors] == ["left", name]
        return
    named = [f"{each}={tmp_path / each[:200]}" for each in known]
    with pytest.raises(BadInputError, match="different names of up to 200"):
        frames_of(tmp_path, sensor=named, extrinsics=str(tmp_path / "extrinsics.json"))


def test_scans_without_times_join_in_their_order(tmp_path: Path) -> None:
    for seed, name in enumerate(("a", "b")):
        (tmp_path / name).mkdir()
        for k in range(3):
            points = np.random.default_rng(seed + 10 * k).uniform(1, 9, (9, 3))
            np.save(tmp_path / name / f"{k:03d}.npy", points.astype(np.float32))
    for file, names in (("extrinsics.json", "ab"), ("both.json", "cd")):
        mounts = {name: {"T_frame_sensor": np.eye(4).tolist()} for name in names}
        (tmp_path / file).write_text(json.dumps(mounts))
    frames = frames_of(tmp_path)
    for number, name in enumerate("ab"):
        for frame, alone in zip(frames, frames_of(tmp_path / name), strict=True):
            require_same(frame, number, alone)
    table = "frame,x,y,z\n" + "".join(f"{k % 3},{k},1,2\n" for k in range(9))
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "table.csv").write_text(table)
    (tmp_path / "d").mkdir()
    np.save(tmp_path / "d" / "0.npy", np.ones((5, 3), np.float32))
    with pytest.raises(BadInputError, match=r"table\.csv: expected one frame a file"):
        frames_of(
            sensor=[f"{name}={tmp_path / name}" for name in "cd"],
            extrinsics=str(tmp_path / "both.json"),
        )
    (tmp_path / "b" / "002.npy").unlink()
    with pytest.raises(BadInputError, match="b: expected 3 frames, as a has, or times"):
        frames_of(tmp_path)


def test_pictures_of_azure_kinect_and_zed_exporters_are_rigs(tmp_path: Path) -> None:
    """Open3D's reader of Kinect recordings, and the export sample of the ZED SDK."""
    rng = np.random.default_rng(0)
    kinect, zed = tmp_path / "kinect", tmp_path / "zed"
    for folder in (kinect / "color", kinect / "depth", zed):
        folder.mkdir(parents=True)
    for k in range(2):
        depth = Image.fromarray(rng.integers(800, 3000, (24, 32)).astype(np.uint16))
        color = Image.fromarray(rng.integers(0, 255, (24, 32, 3), np.uint8))
        depth.save(kinect / "depth" / f"{k:05d}.png")
        color.save(kinect / "color" / f"{k:05d}.jpg")
        depth.save(zed / f"depth{k:06d}.png")
        color.save(zed / f"left{k:06d}.png")
    K = [30.0, 0, 0, 0, 30, 0, 16, 12, 1]
    (kinect / "intrinsic.json").write_text(
        json.dumps({"width": 32, "height": 24, "intrinsic_matrix": K, "color_mode": "MJPG_720P"})
    )
    (zed / "camera.json").write_text(json.dumps({"fx": 30, "fy": 30, "cx": 16, "cy": 12}))
    (tmp_path / "extrinsics.json").write_text(
        json.dumps({n: {"T_frame_sensor": np.eye(4).tolist()} for n in ("kinect", "zed")})
    )
    frames = frames_of(tmp_path)
    assert frames[0].sensors == (Sensor("kinect", "depth"), Sensor("zed", "depth"))
    for number, place in enumerate((kinect, zed)):
        for frame, alone in zip(frames, frames_of(place), strict=True):
            assert alone.rgb is not None
            require_same(frame, number, alone)


# ── data sets ────────────────────────────────────────────────────────────────────────────────


def nuscenes_with_radar(top: Path) -> tuple[Path, Path]:
    """Two samples of a lidar and a radar, between which the vehicle drives 3 m."""
    lidar = nuscenes(top, tables=True)
    tables = top / "v1.0-mini"
    radar = top / "samples" / "RADAR_FRONT"
    radar.mkdir()
    data, egos, sensors = (
        json.loads((tables / f"{name}.json").read_text())
        for name in ("sample_data", "ego_pose", "calibrated_sensor")
    )
    sensors.append({"token": "r", "translation": [3, 0, 0.5], "rotation": [1, 0, 0, 0]})
    kinds = "VERSION 0.7\nFIELDS x y z rcs\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
    for i in range(2):
        stamp = 1533151603500000 + 500_000 * i + 30_000
        name = f"n015__RADAR_FRONT__{stamp}.pcd"
        points = np.random.default_rng(i).uniform(1, 50, (6, 4)).astype("<f4")
        head = f"{kinds}WIDTH 6\nHEIGHT 1\nPOINTS 6\nDATA binary\n"
        (radar / name).write_bytes(head.encode() + points.tobytes())
        egos.append(
            {"token": f"r{i}", "translation": [103.0 + 10 * i, 0, 0], "rotation": [1, 0, 0, 0]}
        )
        data.append({"filename": f"samples/RADAR_FRONT/{name}", "timestamp": stamp,
                     "ego_pose_token": f"r{i}", "calibrated_sensor_token": "r"})  # fmt: skip
    for row in data:
        row["timestamp"] = int(Path(row["filename"]).name.split("__")[2].split(".")[0])
    for name, rows in (("sample_data", data), ("ego_pose", egos), ("calibrated_sensor", sensors)):
        (tables / f"{name}.json").write_text(json.dumps(rows))
    return lidar, radar


def test_nuscenes_with_all_sensors_has_its_radars_at_their_place(tmp_path: Path) -> None:
    lidar, radar = nuscenes_with_radar(tmp_path)
    for place in (tmp_path, tmp_path / "samples", lidar):
        frames = frames_of(place, sensors="all")
        assert frames[0].sensors == (
            Sensor("LIDAR_TOP", "spinning"),
            Sensor("RADAR_FRONT", "radar"),
        )
        for number, folder in enumerate((lidar, radar)):
            for frame, alone in zip(frames, frames_of(folder), strict=True):
                require_same(frame, number, alone)
        # The vehicle drove 3 m between the lidar's sweep and the radar's.
        assert np.allclose(frames[1].parts[1].T_frame_sensor[:3, 3], [3 + 3, 0, 0.5 - 1.8])
        assert frames[1].pose is not None
        assert frames[1].pose[0, 3] == pytest.approx(10)
    assert frames_of(lidar)[0].sensor is None
    with pytest.raises(ForbiddenError):
        open_source([lidar], limits=Limits(roots=(lidar,)), chosen=Corrections(sensors="all"))


@pytest.mark.parametrize("swapped", [False, True])
def test_the_scanners_of_argoverse_are_two_sensors(tmp_path: Path, swapped: bool) -> None:
    """Both scanners in one table, in the vehicle's coordinates, as half precision."""
    up, down = mount(1.35, 0), mount(1.36, 180)
    lidar = tmp_path / "sensors" / "lidar"
    (tmp_path / "calibration").mkdir()
    lidar.mkdir(parents=True)
    tables, times = [], [315_966_265_259_836_000 + i * 100_000_000 for i in range(2)]
    for i, time in enumerate(times):
        rng = np.random.default_rng(i)
        laser = rng.permutation(np.repeat(np.arange(64, dtype=np.uint8), 4))
        turn, range_m = rng.uniform(0, 2 * np.pi, 256), rng.uniform(5, 40, 256)
        own = (
            np.stack([np.cos(turn), np.sin(turn), np.radians(laser % 32 - 16)], 1)
            * range_m[:, None]
        )
        first = (laser < 32) != swapped
        xyz = np.where(
            first[:, None], own @ up[:3, :3].T + up[:3, 3], own @ down[:3, :3].T + down[:3, 3]
        )
        table = {n: xyz[:, k].astype(np.float16) for k, n in enumerate("xyz")}
        table |= {"intensity": np.arange(256).astype(np.uint8), "laser_number": laser}
        feather.write_feather(pa.table(table), lidar / f"{time}.feather")
        tables.append(table)
    turns = Rotation.from_matrix([up[:3, :3], down[:3, :3]]).as_quat()
    rows = {"sensor_name": ["up_lidar", "down_lidar"]}
    rows |= {f"q{n}": turns[:, k] for k, n in enumerate("xyzw")}
    rows |= {f"t{n}_m": [up[k, 3], down[k, 3]] for k, n in enumerate("xyz")}
    feather.write_feather(
        pa.table(rows), tmp_path / "calibration" / "egovehicle_SE3_sensor.feather"
    )
    poses = {"timestamp_ns": times, "qw": [1.0] * 2, **{f"q{n}": [0.0] * 2 for n in "xyz"}}
    poses |= {"tx_m": [0.0, 2.0], "ty_m": [0.0] * 2, "tz_m": [0.0] * 2}
    feather.write_feather(pa.table(poses), tmp_path / "city_SE3_egovehicle.feather")
    frames = frames_of(tmp_path, sensors="all")
    assert frames[0].sensors == (Sensor("up_lidar", "spinning"), Sensor("down_lidar", "spinning"))
    for frame, table in zip(frames, tables, strict=True):
        low = (table["laser_number"] < 32) != swapped
        order = np.concatenate([np.flatnonzero(low), np.flatnonzero(~low)])
        # All points together are exactly those of the file.
        xyz = np.stack([table[n][order].astype(np.float32) for n in "xyz"], 1)
        assert np.array_equal(frame.xyz, xyz)
        assert frame.sensor is not None
        assert np.array_equal(frame.other["laser_number"], table["laser_number"][order])
        assert np.allclose(frame.parts[1].T_frame_sensor, down)
    assert frames[1].pose is not None
    assert frames[1].pose[:3, 3] == pytest.approx([2, 0, 0])


def test_kitti_360_is_its_velodyne_alone(tmp_path: Path) -> None:
    """Profiles of its second scanner are no frames: one turn is 17 of them."""
    drive = tmp_path / "data_3d_raw" / "drive"
    for name in ("velodyne_points", "sick_points"):
        (drive / name / "data").mkdir(parents=True)
    for k in range(3):
        points = np.random.default_rng(k).uniform(2, 40, (50, 4)).astype("<f4")
        points[:, 3] /= 40
        points.tofile(drive / "velodyne_points" / "data" / f"{k:010d}.bin")
        points[:, :2].tofile(drive / "sick_points" / "data" / f"{k:010d}.bin")
    (tmp_path / "data_poses" / "drive").mkdir(parents=True)
    lines = [" ".join(map(str, [k, 1, 0, 0, 5 * k, 0, 1, 0, 0, 0, 0, 1, 0])) for k in range(3)]
    (tmp_path / "data_poses" / "drive" / "poses.txt").write_text("\n".join(lines))
    (tmp_path / "calibration").mkdir()
    (tmp_path / "calibration" / "calib_cam_to_velo.txt").write_text("1 0 0 0.5 0 1 0 0 0 0 1 0\n")
    (tmp_path / "calibration" / "calib_cam_to_pose.txt").write_text(
        "image_00: 1 0 0 2 0 1 0 0 0 0 1 0\n"
    )
    for options in ({}, {"sensors": "all"}):
        with reported() as warnings:
            frames = frames_of(drive, **options)
        assert any("sick_points is left out: profiles of KITTI-360's" in each for each in warnings)
        assert [frame.pose[0, 3] for frame in frames if frame.pose is not None] == [1.5, 6.5, 11.5]
        assert all(frame.sensor is None for frame in frames)
    for place in (drive / "sick_points", drive / "sick_points" / "data"):
        with pytest.raises(BadInputError, match="two coordinates a point; velodyne_points is read"):
            frames_of(place)


def test_options_of_sensors_are_checked() -> None:
    with pytest.raises(BadInputError, match="sensors: expected one or all"):
        Corrections(sensors="both")  # type: ignore[arg-type]
