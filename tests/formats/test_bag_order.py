"""Order of the clouds of bags whose stamps or clocks are set back, and topics that are left out."""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

import pytest

from pointbrush.formats import open_source, reported
from pointbrush.formats.tables.corrections import Corrections
from tests.formats.test_bags import MAGIC, connection, message, op, record, stamp, text

Cloud = tuple[str, float, float]
"""Topic, stamp and time of recording; its number is the x of its points."""


def ros1(folder: Path, clouds: Sequence[Cloud]) -> Path:
    topics = list(dict.fromkeys(topic for topic, _, _ in clouds))
    out = b"#ROSBAG V2.0\n" + record(bytes(200), op=b"\x03", index_pos=bytes(8))
    for number, topic in enumerate(topics):
        out += connection(number, topic.encode(), b"sensor_msgs/PointCloud2")
    for value, (topic, at, logged) in enumerate(clouds):
        conn = struct.pack("<I", topics.index(topic))
        out += record(message(value, cdr=False, at=at), op=b"\x02", conn=conn, time=stamp(logged))
    (folder / "a.bag").write_bytes(out)
    return folder / "a.bag"


def ros2(folder: Path, clouds: Sequence[Cloud]) -> Path:
    topics = list(dict.fromkeys(topic for topic, _, _ in clouds))
    with closing(sqlite3.connect(folder / "a.db3")) as database:
        database.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INT, timestamp INT, data BLOB);"
        )
        for number, topic in enumerate(topics):
            row = (number, topic, "sensor_msgs/msg/PointCloud2")
            database.execute("INSERT INTO topics VALUES (?,?,?)", row)
        for value, (topic, at, logged) in enumerate(clouds):
            data = (topics.index(topic), round(logged * 1e9), message(value, cdr=True, at=at))
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?,?,?)", data)
        database.commit()
    return folder / "a.db3"


def mcap(folder: Path, clouds: Sequence[Cloud]) -> Path:
    topics = list(dict.fromkeys(topic for topic, _, _ in clouds))
    out = MAGIC + op(1, text("ros2") + text("test"))
    out += op(3, struct.pack("<H", 1) + text("sensor_msgs/msg/PointCloud2") + text("") + text(""))
    for number, topic in enumerate(topics):
        channel = struct.pack("<HH", number, 1) + text(topic) + text("cdr")
        out += op(4, channel + struct.pack("<I", 0))
    for value, (topic, at, logged) in enumerate(clouds):
        head = struct.pack("<HIQQ", topics.index(topic), value, round(logged * 1e9), 0)
        out += op(5, head + message(value, cdr=True, at=at))
    (folder / "a.mcap").write_bytes(out + op(0x0F, bytes(4)) + op(2, bytes(20)) + MAGIC)
    return folder / "a.mcap"


Writer = Callable[[Path, Sequence[Cloud]], Path]
every_bag = pytest.mark.parametrize("write", [ros1, ros2, mcap])


def found(path: Path, topic: str | None = None) -> tuple[list[int], float | None, str, str]:
    """Order, rate, its words and the warnings of a bag."""
    chosen = Corrections(topic=topic)
    with reported() as warnings, open_source([path], chosen=chosen) as source:
        order = [int(frame.xyz[0, 0]) for frame in source.frames]
        return order, source.fps, source.listings[0].order, " ".join(warnings)


def on_points(stamps: Sequence[float], recorded: Sequence[float]) -> list[Cloud]:
    return [("/points", *times) for times in zip(stamps, recorded, strict=True)]


@every_bag
@pytest.mark.parametrize("back", [0.33, 0.5, 3600.0])
def test_stamps_that_are_set_back_leave_the_order_of_recording(
    tmp_path: Path, write: Writer, back: float
) -> None:
    recorded = [5000 + k / 10 for k in range(10)]
    stamps = [time - back * (k > 4) for k, time in enumerate(recorded)]
    order, fps, source, said = found(write(tmp_path, on_points(stamps, recorded)))
    assert order == list(range(10))
    assert fps == pytest.approx(10, abs=0.1)
    assert source == "in the order of recording (the times go back: the stamps of the messages)"
    assert "/points: the stamps of the messages: ordered in the order of recording" in said


@every_bag
def test_a_host_whose_clock_is_set_back_leaves_the_order_of_the_file(
    tmp_path: Path, write: Writer
) -> None:
    times = [5000 + k / 10 - 2.04 * (k > 5) for k in range(30)]
    order, fps, source, said = found(write(tmp_path, on_points(times, times)))
    assert order == list(range(30))
    assert fps == pytest.approx(10, abs=0.1)
    assert source.startswith("in the order of recording")
    assert "first by 1.94 s before frame 6" in said


@every_bag
def test_clouds_that_come_late_are_sorted_by_their_stamps(tmp_path: Path, write: Writer) -> None:
    recorded = [5000 + k / 10 for k in range(8)]
    stamps = [recorded[k] - 0.05 for k in (0, 1, 3, 2, 4, 5, 6, 7)]
    order, fps, source, said = found(write(tmp_path, on_points(stamps, recorded)))
    assert (order, fps) == ([0, 1, 3, 2, 4, 5, 6, 7], 10)
    assert source == "by the stamps of the messages"
    assert "the frames are sorted by time" in said


@every_bag
def test_clouds_of_one_stamp_have_the_rate_of_their_recording(
    tmp_path: Path, write: Writer
) -> None:
    recorded = [5000 + k / 10 for k in range(6)]
    order, fps, _, said = found(write(tmp_path, on_points([7.0] * 6, recorded)))
    assert (order, fps) == (list(range(6)), 10)
    assert "5 of 6 times are equal to the time before" in said


@every_bag
def test_topics_that_are_left_out_are_named_unless_one_is_chosen(
    tmp_path: Path, write: Writer
) -> None:
    clouds = [(topic, 100 + k, 100 + k) for k in range(3) for topic in ("/front", "/rear")]
    path = write(tmp_path, clouds)
    order, _, _, said = found(path)
    assert order == [0, 2, 4]
    assert "a." in said
    assert "/front is read; left out, by their number of clouds: /rear (3)" in said
    assert "--topic" in said
    assert found(path, "/rear")[::3] == ([1, 3, 5], "")
