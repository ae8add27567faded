"""PointCloud2 in ROS 1 bags, ROS 2 bags and MCAP, written here by hand from the specifications."""

from __future__ import annotations

import bz2
import sqlite3
import struct
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import zstandard

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats import Limits, open_source, read
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.ros.bag import BagMessage, unpack_chunk
from pointbrush.formats.ros.message import frame_of_message
from pointbrush.formats.tables.corrections import Corrections

STEP = 24
FIELDS = (("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 16, 7), ("rgb", 20, 7))


def cloud(value: float, height: int = 2, width: int = 10) -> bytes:
    rows = np.zeros((height, width, STEP), np.uint8)
    numbers = rows.view("<f4")
    numbers[..., :2] = value
    numbers[..., 2] = 1  # 0 0 0 would be a beam without an echo
    numbers[0, 0, 0] = np.nan
    numbers[..., 4] = value
    numbers.view("<u4")[..., 5] = 0xFF102030
    # Rows are padded by 8 bytes.
    return np.pad(rows.reshape(height, -1), ((0, 0), (0, 8))).tobytes()


class Writer:
    def __init__(self, cdr: bool, big: bool = False):
        self.cdr, self.out, self.order = cdr, b"", ">" if big else "<"

    def number(self, kind: str, value: int) -> None:
        if self.cdr:
            self.out += bytes(-len(self.out) % struct.calcsize("=" + kind))
        self.out += struct.pack(self.order + kind, value)

    def text(self, value: str) -> None:
        data = value.encode() + (b"\0" if self.cdr else b"")
        self.number("I", len(data))
        self.out += data

    def header(self, seconds: float, frame_id: str) -> None:
        if not self.cdr:
            self.number("I", 7)
        self.number("I", int(seconds))
        self.number("I", round(seconds % 1 * 1e9))
        self.text(frame_id)


def message(
    value: float, *, cdr: bool, big: bool = False, height: int = 2, width: int = 10,
    at: float | None = None,
) -> bytes:  # fmt: skip
    writer = Writer(cdr, big)
    writer.header(100.5 + int(value) if at is None else at, "lidar")
    writer.number("I", height)
    writer.number("I", width)
    writer.number("I", len(FIELDS))
    for name, offset, kind in FIELDS:
        writer.text(name)
        writer.number("I", offset)
        writer.number("B", kind)
        writer.number("I", 1)
    writer.number("B", 0)
    writer.number("I", STEP)
    writer.number("I", STEP * width + 8)
    data = cloud(value, height, width)
    writer.number("I", len(data))
    writer.out += data
    writer.number("B", 0)
    return (bytes([0, 0 if big else 1, 0, 0]) if cdr else b"") + writer.out


def check(source) -> None:
    frames = list(source.frames)
    assert [float(frame.xyz[0, 0]) for frame in frames] == [0, 1, 2]
    assert [frame.timestamp for frame in frames] == [100.5, 101.5, 102.5]
    assert [(len(frame), frame.dropped) for frame in frames] == [(19, 1)] * 3
    assert frames[2].intensity.tolist() == [2] * 19
    assert frames[0].rgb[0].tolist() == [0x10, 0x20, 0x30]
    assert (source.count, source.fps) == (3, 1)


# ── ROS 1 ────────────────────────────────────────────────────────────────────────────────────


def record(data: bytes, **header: bytes) -> bytes:
    fields = b"".join(
        struct.pack("<I", len(key) + 1 + len(value)) + key.encode() + b"=" + value
        for key, value in header.items()
    )
    return struct.pack("<I", len(fields)) + fields + struct.pack("<I", len(data)) + data


def stamp(seconds: float) -> bytes:
    return struct.pack("<II", int(seconds), round(seconds % 1 * 1e9))


def connection(number: int, topic: bytes, kind: bytes) -> bytes:
    data = struct.pack("<I", 5 + len(kind)) + b"type=" + kind
    return record(data, op=b"\x07", conn=struct.pack("<I", number), topic=topic)


def rosbag1(compression: str = "none", indexed: bool = True, kind=b"sensor_msgs/PointCloud2"):
    known = connection(0, b"/points", kind) + connection(1, b"/imu", b"sensor_msgs/Imu")
    inner = known
    for i in range(3):
        inner += record(b"junk", op=b"\x02", conn=struct.pack("<I", 1), time=stamp(10 + i / 10))
        body = message(i, cdr=False)
        inner += record(body, op=b"\x02", conn=struct.pack("<I", 0), time=stamp(10 + i / 10))
    packed = bz2.compress(inner) if compression == "bz2" else inner
    chunk = record(
        packed, op=b"\x05", compression=compression.encode(), size=struct.pack("<I", len(inner))
    )
    magic = b"#ROSBAG V2.0\n"

    def bag(position: int) -> bytes:
        return record(
            bytes(200), op=b"\x03", index_pos=struct.pack("<Q", position), conn_count=bytes(4)
        )

    start = len(magic) + len(bag(0)) + len(chunk)
    info = record(
        struct.pack("<IIII", 0, 3, 1, 3),
        op=b"\x06",
        start_time=stamp(10),
        end_time=stamp(10.2),
    )
    if not indexed:
        return magic + bag(0) + chunk
    return magic + bag(start) + chunk + known + info


@pytest.mark.parametrize("compression", ["none", "bz2"])
@pytest.mark.parametrize("indexed", [True, False])
def test_ros_1_bags_are_read_with_and_without_an_index(tmp_path, compression, indexed):
    (tmp_path / "a.bag").write_bytes(rosbag1(compression, indexed))
    check(open_source([tmp_path / "a.bag"]))


def test_bags_without_clouds_name_what_they_have(tmp_path):
    (tmp_path / "a.bag").write_bytes(rosbag1(kind=b"sensor_msgs/Image"))
    got = r"PointCloud2, got /imu \(.*\), /points \(sensor_msgs/Image\)"
    with pytest.raises(BadInputError, match=got):
        open_source([tmp_path / "a.bag"])


def test_cut_off_bags_raise(tmp_path):
    data = rosbag1()
    for size in range(0, len(data), 97):
        (tmp_path / "a.bag").write_bytes(data[:size])
        with pytest.raises(BadInputError, match=r"a\.bag.*expected"):
            list(read(tmp_path / "a.bag"))


# ── ROS 2 ────────────────────────────────────────────────────────────────────────────────────


def rosbag2(path: Path, pack: Callable[[bytes], bytes] = bytes, big: bool = False) -> Path:
    path.parent.mkdir()
    (path.parent / "metadata.yaml").write_text("version: 5")
    with closing(sqlite3.connect(path)) as database:
        database.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INT, timestamp INT, data BLOB);"
            "INSERT INTO topics VALUES (1, '/imu', 'sensor_msgs/msg/Imu'),"
            " (2, '/points', 'sensor_msgs/msg/PointCloud2');"
        )
        for i in (2, 0, 1):
            row = (2, int(1e10 + i * 1e8), pack(message(i, cdr=True, big=big)))
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?,?,?)", row)
        database.commit()
    return path


@pytest.mark.parametrize("big", [False, True])
def test_ros_2_bags_are_read_of_either_byte_order(tmp_path, big):
    rosbag2(tmp_path / "run" / "run_0.db3", big=big)
    check(open_source([tmp_path / "run"]))
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == [
        *("metadata.yaml", "run_0.db3")
    ]


def streamed(data: bytes) -> bytes:
    """Packed without its size, as a stream is."""
    packer = zstandard.ZstdCompressor().compressobj()
    return packer.compress(data) + packer.flush()


@pytest.mark.parametrize("pack", [zstandard.compress, streamed])
def test_messages_that_a_recorder_packed_are_read(tmp_path, pack):
    check(open_source([rosbag2(tmp_path / "run" / "run_0.db3", pack)]))
    (tmp_path / "a.mcap").write_bytes(mcap("", "cdr", statistics=True, pack=pack))
    check(open_source([tmp_path / "a.mcap"]))


def test_damaged_packed_messages_raise(tmp_path):
    bag = rosbag2(tmp_path / "run" / "run_0.db3", lambda data: zstandard.compress(data)[:-9])
    with pytest.raises(BadInputError, match=r"run_0\.db3: expected a"):
        open_source([bag])


@pytest.mark.parametrize("pack", [zstandard.compress, streamed])
def test_files_that_a_recorder_packed_are_read_and_leave_nothing_behind(
    tmp_path, pack, monkeypatch
):
    (tmp_path / "scratch").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "scratch"))
    bag = rosbag2(tmp_path / "run" / "run_0.db3")
    packed = bag.with_name("run_0.db3.zstd")
    packed.write_bytes(pack(bag.read_bytes()))
    bag.unlink()
    (tmp_path / "a.mcap.zstd").write_bytes(pack(mcap("", "cdr", statistics=True)))
    for path, name in (
        (tmp_path / "run", "run"),
        (packed, "run_0"),
        (tmp_path / "a.mcap.zstd", "a"),
    ):
        with open_source([path]) as source:
            check(source)
            assert source.name == name
        with pytest.raises(TooLargeError, match=rf"{path.name}: expected at most 1000 bytes"):
            open_source([path], limits=Limits(max_unpacked_bytes=1000))
    packed.write_bytes(b"not packed")
    with pytest.raises(BadInputError, match="run: expected a whole archive"):
        open_source([tmp_path / "run"])
    assert list((tmp_path / "scratch").iterdir()) == []


@pytest.mark.parametrize(
    ("name", "time"),
    [("x'ff'", "1"), ("'/points'", "'soon'"), ("NULL", "1"), ("'/points'", "x'00'")],
)
def test_values_of_other_types_raise(tmp_path, name, time):
    with closing(sqlite3.connect(tmp_path / "a.db3")) as database:
        database.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INT, timestamp INT, data BLOB);"
            f"INSERT INTO topics VALUES (1, {name}, 'sensor_msgs/msg/PointCloud2');"
            f"INSERT INTO messages VALUES (1, 1, {time}, x'00');"
        )
    with pytest.raises(
        BadInputError, match=r"a\.db3: expected (topics with names|messages as bytes with a time)"
    ):
        open_source([tmp_path / "a.db3"])


def test_a_view_in_place_of_a_table_is_not_run(tmp_path):
    with closing(sqlite3.connect(tmp_path / "a.db3")) as database:
        database.executescript(
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INT, timestamp INT, data BLOB);"
            "CREATE VIEW topics AS WITH RECURSIVE t(id) AS (SELECT 1 UNION ALL SELECT id + 1"
            " FROM t) SELECT id, 'a' AS name, 'b' AS type FROM t;"
        )
    with pytest.raises(BadInputError, match="tables topics and messages"):
        open_source([tmp_path / "a.db3"])


@pytest.mark.parametrize("data", [b"", b"SQLite format 3\0" + bytes(200), b"not a database" * 99])
def test_damaged_ros_2_bags_raise(tmp_path, data):
    (tmp_path / "a.db3").write_bytes(data)
    with pytest.raises(BadInputError, match=r"a\.db3: expected"):
        open_source([tmp_path / "a.db3"])


# ── MCAP ─────────────────────────────────────────────────────────────────────────────────────

MAGIC = b"\x89MCAP0\r\n"


def op(code: int, content: bytes) -> bytes:
    return struct.pack("<BQ", code, len(content)) + content


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def mcap(
    compression: str, encoding: str, statistics: bool, pack: Callable[[bytes], bytes] = bytes
) -> bytes:
    cdr = encoding == "cdr"
    kind = "sensor_msgs/msg/PointCloud2" if cdr else "sensor_msgs/PointCloud2"
    known = op(3, struct.pack("<H", 1) + text(kind) + text("ros2msg") + text(""))
    channel = struct.pack("<HH", 4, 1) + text("/points") + text(encoding)
    known += op(4, channel + struct.pack("<I", 0))
    inner = known + b"".join(
        op(5, struct.pack("<HIQQ", 4, i, int(1e10 + i * 1e8), 0) + pack(message(i, cdr=cdr)))
        for i in range(3)
    )
    packed = zstandard.compress(inner) if compression == "zstd" else inner
    chunk = struct.pack("<QQQI", 0, 0, len(inner), 0) + text(compression)
    out = MAGIC + op(1, text("ros2") + text("test"))
    out += op(6, chunk + struct.pack("<Q", len(packed)) + packed) + op(0x0F, bytes(4))
    summary = 0
    if statistics:
        summary = len(out)
        numbers = struct.pack("<QHIIIIQQ", 3, 1, 1, 0, 0, 1, int(1e10), int(1e10 + 2e8))
        out += known + op(0x0B, numbers + struct.pack("<IHQ", 10, 4, 3))
    return out + op(2, struct.pack("<QQI", summary, 0, 0)) + MAGIC


@pytest.mark.parametrize("compression", ["", "zstd"])
@pytest.mark.parametrize("encoding", ["cdr", "ros1"])
@pytest.mark.parametrize("statistics", [True, False])
def test_mcap_is_read_in_each_compression_and_encoding(tmp_path, compression, encoding, statistics):
    (tmp_path / "a.mcap").write_bytes(mcap(compression, encoding, statistics))
    check(open_source([tmp_path / "a.mcap"]))


def test_cut_off_mcap_raises(tmp_path):
    data = mcap("zstd", "cdr", True)
    for size in range(0, len(data), 41):
        (tmp_path / "a.mcap").write_bytes(data[:size])
        with pytest.raises(BadInputError, match=r"a\.mcap.*expected"):
            list(read(tmp_path / "a.mcap"))


# ── messages and LZ4 ─────────────────────────────────────────────────────────────────────────


def test_cut_off_messages_raise():
    whole = message(1, cdr=True)
    for size in range(0, len(whole) - 1, 13):
        with pytest.raises(BadInputError):
            frame_of_message("a", BagMessage("cdr", 0.0, whole[:size]), ReadOptions())


def test_messages_whose_numbers_do_not_fit_raise():
    good = message(1, cdr=False)
    at = good.index(b"lidar") + 5
    tall = good[:at] + struct.pack("<I", 3) + good[at + 4 :]
    with pytest.raises(BadInputError, match="expected 3 rows of 10 points"):
        frame_of_message("a", BagMessage("ros1", 0.0, tall), ReadOptions())
    wide = good[: at + 4] + struct.pack("<I", 11) + good[at + 8 :]
    with pytest.raises(BadInputError, match="rows of 264 bytes or more, got rows of 248"):
        frame_of_message("a", BagMessage("ros1", 0.0, wide), ReadOptions())
    huge = good[:at] + struct.pack("<II", 2**31, 2**31) + good[at + 8 :]
    with pytest.raises(TooLargeError, match="points"):
        frame_of_message("a", BagMessage("ros1", 0.0, huge), ReadOptions())


# lz4.frame.compress(b"pointbrush " * 30 + bytes(range(40)), store_size=False) of python-lz4.
LZ4 = bytes.fromhex(
    "04224d186040823a000000bf706f696e746272757368200b00ff2df019000102030405060708090a0b0c0d0e0f10"
    "1112131415161718191a1b1c1d1e1f202122232425262700000000"
)


def frame_of(block: bytes) -> bytes:
    return b"\x04\x22\x4d\x18\x60\x40\x82" + struct.pack("<I", len(block)) + block + bytes(4)


@pytest.mark.parametrize(
    ("block", "expected"),
    [
        (b"\x50hello", b"hello"),
        (b"\x11a\x01\x00\x50world", b"a" * 6 + b"world"),
        (b"\xf0\x05" + b"x" * 20, b"x" * 20),
    ],
)
def test_lz4_blocks_give_what_was_packed_or_raise(block, expected):
    assert unpack_chunk("a", frame_of(block), "lz4", len(expected)) == expected
    with pytest.raises(BadInputError, match="LZ4"):
        unpack_chunk("a", frame_of(block), "lz4", len(expected) + 1)
    with pytest.raises(BadInputError, match="LZ4"):
        unpack_chunk("a", frame_of(block)[:-5], "lz4", len(expected))


def test_an_lz4_frame_of_another_program():
    expected = b"pointbrush " * 30 + bytes(range(40))
    assert unpack_chunk("a", LZ4, "lz4", len(expected)) == expected


def test_a_real_lz4_bag_without_clouds_says_what_it_has(shared):
    with pytest.raises(BadInputError, match=r"PointCloud2, got .*Depth_0/image/data"):
        open_source([shared / "formats" / "bags" / "librealsense__single_depth_color_640x480.bag"])


@pytest.mark.parametrize("beside", [True, False])
def test_poses_of_a_file_are_taken_at_the_stamps_of_a_bag(tmp_path, beside):
    path = tmp_path / "drive.bag"
    path.write_bytes(rosbag1())
    with open_source([path]) as source:
        stamps = [frame.timestamp for frame in source.frames]
    odometry = (tmp_path if beside else tmp_path / "elsewhere") / "odometry.txt"
    odometry.parent.mkdir(exist_ok=True)
    first = stamps[0] - 0.5
    odometry.write_text("".join(f"{first + k} {k} 0 0 0 0 0 1\n" for k in range(9)))
    with open_source([path], chosen=Corrections(poses=str(odometry))) as source:
        places = [frame.pose[0, 3] for frame in source.frames if frame.pose is not None]
        assert source.listings[0].poses_from == "odometry.txt"
    assert places == pytest.approx([stamp - first for stamp in stamps], abs=1e-6)
