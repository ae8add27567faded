"""Pictures of cameras beside recordings: cameras.json, KITTI, nuScenes and bags."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pointbrush.errors import BadInputError, ForbiddenError
from pointbrush.formats import Limits, open_source
from pointbrush.formats.cameras.pictures import Picture
from tests.formats.test_bags import Writer, connection, message, record, stamp

K = [[500.0, 0, 320], [0, 510, 240], [0, 0, 1]]
AHEAD = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
"""From a scanner (x ahead, z up) to a camera at its place (z ahead, y down)."""


def jpeg(seed: int, width: int = 64, height: int = 48, kind: str = "JPEG") -> bytes:
    pixels = np.random.default_rng(seed).integers(0, 255, (height, width, 3), np.uint8)
    packed = io.BytesIO()
    Image.fromarray(pixels).save(packed, kind)
    return packed.getvalue()


def scans(folder: Path, count: int = 3, name: str = "{:06d}.bin") -> None:
    folder.mkdir(parents=True)
    for i in range(count):
        table = np.random.default_rng(i).uniform(-30, 30, (60, 4)).astype("<f4")
        table[:, 3] = np.abs(table[:, 3]) / 30
        (folder / name.format(i)).write_bytes(table.tobytes())


def pictures_of(path: Path, limits: Limits | None = None) -> list[Picture]:
    with open_source([path], limits=limits) as source:
        found = source.pictures
        return [] if found is None else sorted(found.pictures(), key=lambda p: p.frame)


def described(folder: Path, **fields: object) -> Path:
    """A folder of three frames with a cameras.json."""
    folder.mkdir()
    for i in range(3):
        np.save(folder / f"{i}.npy", np.random.default_rng(i).normal(0, 1, (9, 3)))
    (folder / "front").mkdir()
    for i in (0, 2):
        (folder / "front" / f"{i}.jpg").write_bytes(jpeg(i))
    camera = {
        "name": "front",
        "K": K,
        "distortion": [0.1, -0.2, 0, 0, 0.05],
        "T_camera_frame": AHEAD.tolist(),
        "files": ["front/0.jpg", None, "front/2.jpg"],
        **fields,
    }
    (folder / "cameras.json").write_text(json.dumps({"cameras": [camera]}))
    return folder


def test_a_cameras_file_gives_each_frame_its_pictures_as_they_are(tmp_path: Path) -> None:
    first, last = pictures_of(described(tmp_path / "room"))
    assert [first.frame, last.frame] == [0, 2]
    assert first.content == jpeg(0)
    assert (first.width, first.height, first.ending) == (64, 48, ".jpg")
    assert np.array_equal(first.camera.K, K)
    assert np.array_equal(first.camera.T_camera_frame, AHEAD)
    assert first.camera.distortion == (0.1, -0.2, 0, 0, 0.05)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"K": [1, 2]}, "camera 0: expected K as 3x3 numbers, got 2"),
        ({"name": ""}, "camera 0: expected a name"),
        ({"files": ["front/0.jpg"]}, "a file for each of 3 frames, got 1"),
        ({"files": ["../room.jpg", None, None]}, "files below the folder"),
        ({"files": ["/etc/passwd", None, None]}, "files below the folder"),
        ({"files": {"7": "front/0.jpg"}}, "got 1 of no frame: 7"),
        ({"T_camera_frame": "left"}, "expected T_camera_frame in numbers"),
    ],
)
def test_a_wrong_cameras_file_says_which_entry(
    tmp_path: Path, fields: dict[str, object], said: str
) -> None:
    with pytest.raises(BadInputError, match=said):
        pictures_of(described(tmp_path / "room", **fields))


def test_files_by_the_names_of_frames(tmp_path: Path) -> None:
    found = pictures_of(described(tmp_path / "room", files={"2": "front/2.jpg"}))
    assert [each.frame for each in found] == [2]


def test_a_picture_that_leads_out_or_is_none_is_left_out_and_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = described(tmp_path / "room")
    secret = tmp_path / "secret.jpg"
    secret.write_bytes(jpeg(5))
    (folder / "front" / "0.jpg").unlink()
    (folder / "front" / "0.jpg").symlink_to(secret)
    assert [each.frame for each in pictures_of(folder)] == [2]
    assert "1 picture(s) of cameras are left out; the first: 0.jpg" in caplog.text
    with pytest.raises(ForbiddenError):
        pictures_of(folder, Limits(roots=(folder.resolve(),)))
    (folder / "front" / "0.jpg").unlink()
    (folder / "front" / "0.jpg").write_text("<svg onload='alert(1)'/>")
    assert [each.frame for each in pictures_of(folder)] == [2]


def test_a_scale_of_the_points_holds_for_the_cameras_place(tmp_path: Path) -> None:
    from pointbrush.formats.tables.corrections import Corrections

    moved = AHEAD.copy()
    moved[:3, 3] = 100, 200, 300
    folder = described(tmp_path / "room", T_camera_frame=moved.tolist())
    with open_source([folder], chosen=Corrections(scale=0.001)) as source:
        assert source.pictures is not None
        (first, *_) = source.pictures.pictures()
    assert first.camera.T_camera_frame is not None
    assert first.camera.T_camera_frame[:3, 3] == pytest.approx([0.1, 0.2, 0.3])


# ── KITTI ────────────────────────────────────────────────────────────────────────────────────

P2 = "P2: 700 0 600 -350 0 700 180 0 0 0 1 0\n"
TR = " 0 -1 0 0.1 0 0 -1 0.2 1 0 0 0.3\n"


def test_the_cameras_of_a_kitti_odometry_sequence(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    scans(tmp_path / "04" / "velodyne")
    (tmp_path / "04" / "image_2").mkdir()
    for i in (0, 2):
        (tmp_path / "04" / "image_2" / f"{i:06d}.png").write_bytes(jpeg(i, kind="PNG"))
    (tmp_path / "04" / "calib.txt").write_text(P2)
    first, last = pictures_of(tmp_path / "04")
    assert (first.frame, last.frame, first.ending) == (0, 2, ".png")
    assert first.camera.K is not None
    assert first.camera.T_camera_frame is None
    assert "points cannot be projected into them" in caplog.text

    (tmp_path / "04" / "calib.txt").write_text(P2 + "Tr:" + TR)
    first, _ = pictures_of(tmp_path / "04" / "velodyne")
    T = first.camera.T_camera_frame
    assert T is not None
    # What KITTI's development kit does: P2 Tr x.
    point = np.array([10, 1, -1, 1.0])
    P = np.array([[700, 0, 600, -350], [0, 700, 180, 0], [0, 0, 1, 0.0]])
    Tr = np.vstack([np.array(TR.split(), float).reshape(3, 4), [0, 0, 0, 1]])
    assert first.camera.K is not None
    assert first.camera.K @ (T @ point)[:3] == pytest.approx(P @ Tr @ point)


def test_the_cameras_of_kitti_tracking_object_and_raw(tmp_path: Path) -> None:
    calibration = P2 + "R_rect 1 0 0 0 1 0 0 0 1\n" + "Tr_velo_cam" + TR
    tracking = tmp_path / "tracking"
    scans(tracking / "velodyne" / "0003")
    (tracking / "image_02" / "0003").mkdir(parents=True)
    (tracking / "image_02" / "0003" / "000001.png").write_bytes(jpeg(1, kind="PNG"))
    (tracking / "calib").mkdir()
    (tracking / "calib" / "0003.txt").write_text(calibration)
    (found,) = pictures_of(tracking / "velodyne" / "0003")
    assert (found.frame, found.camera.name) == (1, "image_02")
    assert found.camera.T_camera_frame is not None

    objects = tmp_path / "object"
    scans(objects / "velodyne", 2)
    (objects / "image_2").mkdir()
    (objects / "calib").mkdir()
    for i in range(2):
        (objects / "image_2" / f"{i:06d}.png").write_bytes(jpeg(i, kind="PNG"))
        moved = P2.replace("-350", str(-100 * i))
        (objects / "calib" / f"{i:06d}.txt").write_text(
            f"{moved}R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam:{TR}"
        )
    places = [p.camera.T_camera_frame for p in pictures_of(objects)]
    assert places[0] is not None
    assert places[1] is not None
    assert (places[1] - places[0])[0, 3] == pytest.approx(-100 / 700)

    drive = tmp_path / "2011_09_26" / "drive"
    scans(drive / "velodyne_points" / "data", name="{:010d}.bin")
    (drive / "image_02" / "data").mkdir(parents=True)
    (drive / "image_02" / "data" / "0000000002.png").write_bytes(jpeg(2, kind="PNG"))
    (drive.parent / "calib_cam_to_cam.txt").write_text(
        P2.replace("P2", "P_rect_02") + "R_rect_00: 1 0 0 0 1 0 0 0 1\n"
    )
    (drive.parent / "calib_velo_to_cam.txt").write_text("R: 0 -1 0 0 0 -1 1 0 0\nT: 0.1 0.2 0.3\n")
    (found,) = pictures_of(drive)
    assert found.frame == 2
    assert found.camera.T_camera_frame is not None
    assert found.camera.T_camera_frame[:3, 3] == pytest.approx([0.1 - 0.5, 0.2, 0.3])


# ── nuScenes ─────────────────────────────────────────────────────────────────────────────────


def nuscenes(top: Path, tables: bool) -> Path:
    """Two sweeps with a picture each; the vehicle drives 2 m between sweep and picture."""
    lidar, camera = top / "samples" / "LIDAR_TOP", top / "samples" / "CAM_FRONT"
    lidar.mkdir(parents=True)
    camera.mkdir()
    data, egos = [], []
    for i in range(2):
        table = np.random.default_rng(i).uniform(-30, 30, (40, 5)).astype("<f4")
        table[:, 4] = np.arange(40) % 32
        stamp = 1533151603500000 + 500_000 * i
        (lidar / f"n015__LIDAR_TOP__{stamp}.pcd.bin").write_bytes(table.tobytes())
        (camera / f"n015__CAM_FRONT__{stamp + 20_000}.jpg").write_bytes(jpeg(i))
        for k, (place, sensor) in enumerate((("LIDAR_TOP", "l"), ("CAM_FRONT", "c"))):
            name = f"n015__{place}__{stamp + 20_000 * k}{'.jpg' if k else '.pcd.bin'}"
            data.append({
                "filename": f"samples/{place}/{name}",
                "sample_token": f"s{i}",
                "ego_pose_token": f"e{i}{k}",
                "calibrated_sensor_token": sensor,
                "is_key_frame": True,
            })  # fmt: skip
            egos.append({
                "token": f"e{i}{k}",
                "translation": [100.0 + 10 * i + 2 * k, 0, 0],
                "rotation": [1, 0, 0, 0],
            })  # fmt: skip
    sensors = [
        {"token": "l", "translation": [0, 0, 1.8], "rotation": [1, 0, 0, 0]},
        {
            "token": "c",
            "translation": [1.5, 0, 1.5],
            "rotation": [0.5, -0.5, 0.5, -0.5],
            "camera_intrinsic": K,
        },
    ]
    if tables:
        (top / "v1.0-mini").mkdir()
        written = (("sample_data", data), ("ego_pose", egos), ("calibrated_sensor", sensors))
        for name, rows in written:
            (top / "v1.0-mini" / f"{name}.json").write_text(json.dumps(rows))
    return lidar


def test_nuscenes_tables_give_poses_and_cameras(tmp_path: Path) -> None:
    lidar = nuscenes(tmp_path, tables=True)
    with open_source([lidar]) as source:
        frames = list(source.frames)
        assert source.listings[0].poses_from == "v1.0-mini"
    assert frames[1].pose is not None
    assert frames[1].pose[:3, 3] == pytest.approx([10, 0, 0])
    first, second = pictures_of(lidar)
    assert second.content == jpeg(1)
    T = first.camera.T_camera_frame
    assert T is not None
    # 10 m ahead of the scanner is 10 - 2 - 1.5 m ahead of the camera, 0.3 m above it.
    assert (T @ [10, 0, 0, 1])[:3] == pytest.approx([0, -0.3, 6.5])


def test_nuscenes_without_tables_has_pictures_by_time(tmp_path: Path) -> None:
    first, second = pictures_of(nuscenes(tmp_path, tables=False))
    assert [first.content, second.content] == [jpeg(0), jpeg(1)]
    assert first.camera.name == "CAM_FRONT"
    assert first.camera.K is None


# ── bags ─────────────────────────────────────────────────────────────────────────────────────


def rosbag1(*rows: tuple[str, str, float, bytes]) -> bytes:
    """A bag of messages (topic, type, time, content)."""
    numbers: dict[str, int] = {}
    inner = b""
    for topic, kind, seconds, content in rows:
        if topic not in numbers:
            numbers[topic] = len(numbers)
            inner += connection(numbers[topic], topic.encode(), kind.encode())
        number = struct.pack("<I", numbers[topic])
        inner += record(content, op=b"\x02", conn=number, time=stamp(seconds))
    head = record(bytes(200), op=b"\x03", index_pos=bytes(8), conn_count=bytes(4))
    return b"#ROSBAG V2.0\n" + head + inner


def image_message(seconds: float, content: bytes, *, compressed: bool) -> bytes:
    out = Writer(cdr=False)
    out.header(seconds, "camera")
    if compressed:
        out.text("jpeg")
    else:
        out.number("I", 4)
        out.number("I", 6)
        out.text("bgr8")
        out.number("B", 0)
        out.number("I", 18)
    out.number("I", len(content))
    return out.out + content


def info_message(P: np.ndarray | None = None) -> bytes:
    out = Writer(cdr=False)
    out.header(0, "camera")
    out.number("I", 48)
    out.number("I", 64)
    out.text("plumb_bob")
    out.number("I", 5)
    values = np.zeros(12) if P is None else P.ravel()
    for value in (0.1, -0.2, 0, 0, 0.05, *np.ravel(K), *np.eye(3).ravel(), *values):
        out.number("d", value)
    return out.out


def transform_message(*links: tuple[str, str, tuple[float, float, float]]) -> bytes:
    """Transforms (parent, child, place); a mast under the scanner, and the camera on it."""
    links = links or (("mast", "lidar", (0, 0, 0.5)), ("mast", "camera", (0.2, 0, 0)))
    out = Writer(cdr=False)
    out.number("I", len(links))
    for parent, child, place in links:
        out.header(0, parent)
        out.text(child)
        for value in (*place, 0, 0, 0, 1):
            out.number("d", value)
    return out.out


@pytest.mark.parametrize("compressed", [True, False])
def test_pictures_of_a_bag_with_camera_info(tmp_path: Path, compressed: bool) -> None:
    pixels = np.random.default_rng(0).integers(0, 255, (4, 6, 3), np.uint8)
    content = jpeg(3) if compressed else pixels.tobytes()
    taken = image_message(101.54, content, compressed=compressed)
    kind = "CompressedImage" if compressed else "Image"
    topic = "/cam/image_raw" + ("/compressed" if compressed else "")
    path = tmp_path / "drive.bag"
    path.write_bytes(
        rosbag1(
            ("/tf_static", "tf2_msgs/TFMessage", 0.0, transform_message()),
            ("/cam/camera_info", "sensor_msgs/CameraInfo", 0.0, info_message()),
            ("/points", "sensor_msgs/PointCloud2", 101.5, message(1, cdr=False)),
            (topic, f"sensor_msgs/{kind}", 101.54, taken),
            ("/points", "sensor_msgs/PointCloud2", 102.5, message(2, cdr=False)),
        )
    )  # fmt: skip
    (found,) = pictures_of(path)
    assert (found.frame, found.camera.name) == (0, "cam")
    if compressed:
        assert found.content == content
    else:
        with Image.open(io.BytesIO(found.content)) as image:
            assert np.array_equal(np.asarray(image), pixels[..., ::-1])
    assert np.array_equal(found.camera.K, K)
    assert found.camera.distortion == (0.1, -0.2, 0, 0, 0.05)
    T = found.camera.T_camera_frame
    assert T is not None
    assert T[:3, 3] == pytest.approx([-0.2, 0, 0.5])


def test_an_image_that_is_cut_off_is_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    short = image_message(101.5, b"", compressed=True)[:-4] + struct.pack("<I", 999)
    path = tmp_path / "drive.bag"
    path.write_bytes(
        rosbag1(
            ("/points", "sensor_msgs/PointCloud2", 101.5, message(1, cdr=False)),
            ("/cam/image/compressed", "sensor_msgs/CompressedImage", 101.5, short),
        )
    )
    assert pictures_of(path) == []
    assert "it is cut off" in caplog.text


def drive(tmp_path: Path, *rows: tuple[str, str, float, bytes], topic: str, info: bytes) -> Path:
    """A bag of one cloud and one picture on ``topic``, with messages before them."""
    taken = image_message(101.5, jpeg(3), compressed=True)
    space = topic.split("/")[1]
    path = tmp_path / "drive.bag"
    path.write_bytes(
        rosbag1(
            *rows,
            (f"/{space}/camera_info", "sensor_msgs/CameraInfo", 0.0, info),
            ("/points", "sensor_msgs/PointCloud2", 101.5, message(1, cdr=False)),
            (f"{topic}/compressed", "sensor_msgs/CompressedImage", 101.5, taken),
        )
    )
    return path


@pytest.mark.parametrize("name", ["image_rect", "image_rect_color", "image_rect_raw"])
def test_rectified_pictures_are_seen_by_the_projection(tmp_path: Path, name: str) -> None:
    # As the right camera of a pair, 0.1 m beside the left one.
    P = np.array([[60.0, 0, 30, -6], [0, 61, 25, 0], [0, 0, 1, 0]])
    static = ("/tf_static", "tf2_msgs/TFMessage", 0.0, transform_message())
    (found,) = pictures_of(drive(tmp_path, static, topic=f"/cam/{name}", info=info_message(P)))
    camera = found.camera
    assert np.array_equal(camera.K, P[:, :3])
    assert camera.distortion == ()
    assert camera.T_camera_frame is not None
    assert camera.T_camera_frame[:3, 3] == pytest.approx([-0.2 - 0.1, 0, 0.5])


def test_a_rectified_camera_without_a_projection_is_not_guessed(tmp_path: Path) -> None:
    (found,) = pictures_of(drive(tmp_path, topic="/cam/image_rect", info=info_message()))
    assert found.camera.K is None


def test_mounts_that_are_repeated_on_tf_place_the_camera(tmp_path: Path) -> None:
    rows = []
    for k in range(3):
        moving = ("odom", "mast", (float(k), 0.0, 0.0))
        fixed = (("mast", "lidar", (0.0, 0.0, 0.5)), ("mast", "camera", (0.2, 0.0, 0.0)))
        rows.append(("/tf", "tf/tfMessage", 101.0 + k, transform_message(moving, *fixed)))
    (found,) = pictures_of(drive(tmp_path, *rows, topic="/cam/image_raw", info=info_message()))
    assert found.camera.T_camera_frame is not None
    assert found.camera.T_camera_frame[:3, 3] == pytest.approx([-0.2, 0, 0.5])


def test_a_sensor_that_moves_on_tf_has_no_place(tmp_path: Path) -> None:
    rows = []
    for k in range(3):
        links = (("mast", "lidar", (0.0, 0.0, 0.5)), ("mast", "camera", (0.1 * k, 0.0, 0.0)))
        rows.append(("/tf", "tf2_msgs/TFMessage", 101.0 + k, transform_message(*links)))
    (found,) = pictures_of(drive(tmp_path, *rows, topic="/cam/image_raw", info=info_message()))
    assert found.camera.T_camera_frame is None


def bag_beside_a_cloud(folder: Path, topic: str, encoding: bytes) -> Path:
    """Write a bag of a cloud and a raw image in an encoding."""
    taken = image_message(101.5, bytes(72), compressed=False).replace(b"bgr8", encoding)
    path = folder / "drive.bag"
    path.write_bytes(
        rosbag1(
            ("/points", "sensor_msgs/PointCloud2", 101.5, message(1, cdr=False)),
            (topic, "sensor_msgs/Image", 101.5, taken),
        )
    )
    return path


def test_pictures_of_an_unknown_encoding_are_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert pictures_of(bag_beside_a_cloud(tmp_path, "/cam/image_raw", b"rgbe")) == []
    assert "expected pictures of mono8, " in caplog.text
    assert "got 'rgbe'" in caplog.text


def test_depth_images_beside_clouds_are_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert pictures_of(bag_beside_a_cloud(tmp_path, "/camera/depth/image_raw", b"16UC1")) == []
    assert "/camera/depth/image_raw are left out: turn depth images into points" in caplog.text


def test_a_bag_of_depth_images_alone_says_what_to_do(tmp_path: Path) -> None:
    taken = image_message(101.5, bytes(72), compressed=False).replace(b"bgr8", b"16UC1")
    path = tmp_path / "drive.bag"
    path.write_bytes(rosbag1(("/camera/depth/image_raw", "sensor_msgs/Image", 101.5, taken)))
    with pytest.raises(BadInputError, match=r"image_raw .*turn depth images into points"):
        pictures_of(path)
