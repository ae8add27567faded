"""What a person says of files wins over what the files seem to say."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats import open_source
from pointbrush.formats.tables.corrections import Corrections, parse_corrections
from pointbrush.frame import PointFrame
from tests.formats.test_bags import Writer, connection, message, record, stamp

SEVEN = "1 2 3 10 20 30 7\n4 5 6 40 50 60 8\n"


def one(path: Path, **said: Any) -> PointFrame:
    with open_source([path], chosen=parse_corrections(said)) as source:
        (frame,) = source.frames
        return frame


def text(tmp_path: Path, content: str, name: str = "a.txt") -> Path:
    path = tmp_path / name
    path.write_text(content)
    return path


def test_columns_are_what_a_person_says(tmp_path: Path) -> None:
    path = text(tmp_path, SEVEN)
    frame = one(path, columns="x,y,z,-,-,intensity,label")
    assert frame.intensity is not None
    assert frame.intensity.tolist() == [30, 60]
    assert frame.label is not None
    assert frame.label.tolist() == [7, 8]
    assert (frame.rgb, dict(frame.other)) == (None, {})
    frame = one(path, columns=["z", "y", "x", "red", "green", "blue", "hardness"])
    assert frame.xyz[0].tolist() == [3, 2, 1]
    assert frame.rgb is not None
    assert frame.rgb[1].tolist() == [40, 50, 60]
    assert frame.other["hardness"].tolist() == [7, 8]


def test_columns_of_a_header_by_name_or_in_order(tmp_path: Path) -> None:
    path = text(tmp_path, "x,y,z,kind,label\n1,2,3,5,9\n4,5,6,6,9\n", "a.csv")
    assert one(path).label.tolist() == [9, 9]  # type: ignore[union-attr]
    assert one(path, columns="kind=label").label.tolist() == [5, 6]  # type: ignore[union-attr]
    assert one(path, columns="x,y,z,label,-").label.tolist() == [5, 6]  # type: ignore[union-attr]
    with pytest.raises(BadInputError, match=r"5 columns \(x, y, z, kind, label\), got 3"):
        one(path, columns="x,y,z")
    with pytest.raises(BadInputError, match="columns of x, y, z, kind, label, got 'sort'"):
        one(path, columns="sort=label")


def test_columns_of_arrays_and_of_files_with_names(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.arange(12.0).reshape(2, 6))
    assert one(tmp_path / "a.npy", columns="-,-,-,x,y,z").xyz[0].tolist() == [3, 4, 5]
    ply = (
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nproperty float tree\nend_header\n1 2 3 4\n"
    )
    assert one(text(tmp_path, ply, "a.ply"), columns="tree=label").label.tolist() == [4]  # type: ignore[union-attr]


def test_a_delimiter_and_a_decimal_comma(tmp_path: Path) -> None:
    path = text(tmp_path, "1,5|2,5|3,5\n4,0|5,0|6,0\n")
    assert one(path, delimiter="pipe").xyz[0].tolist() == [1.5, 2.5, 3.5]
    assert one(path, delimiter="|", decimal_comma=True).xyz[0].tolist() == [1.5, 2.5, 3.5]
    ambiguous = text(tmp_path, "1,5 2,25 3,125\n1,5 2,25 3,125\n", "b.txt")
    assert len(one(ambiguous).xyz) == 2


def test_scale_makes_metres_of_everything(tmp_path: Path) -> None:
    xyz = np.array([[1000.0, 0, 0], [0, 500, 250]])
    pose = np.eye(4)
    pose[0, 3] = 2000
    np.savez(tmp_path / "a.npz", xyz=xyz, pose=pose, viewpoint=np.array([100.0, 0, 0]))
    frame = one(tmp_path / "a.npz", scale=0.001)
    assert np.array_equal(frame.xyz, xyz * 0.001)
    assert frame.pose is not None
    assert frame.pose[0, 3] == 2
    assert frame.viewpoint is not None
    assert frame.viewpoint[0] == pytest.approx(0.1)


def test_poses_are_left_out_or_those_of_a_file(tmp_path: Path) -> None:
    for i in range(2):
        np.save(tmp_path / f"{i}.npy", np.ones((3, 3)) * i + 1)
    rows = [f"1 0 0 {i} 0 1 0 0 0 0 1 0" for i in range(2)]
    (tmp_path / "poses.txt").write_text("\n".join(rows))
    (tmp_path / "other.txt").write_text("5 0 0 0 0 0 1\n6 0 0 0 0 0 1\n")

    def shifts(poses: str) -> list[float | None]:
        with open_source([tmp_path], chosen=Corrections(poses=poses)) as source:
            return [None if f.pose is None else float(f.pose[0, 3]) for f in source.frames]

    assert shifts("auto") == [0, 1]
    assert shifts("none") == [None, None]
    assert shifts(str(tmp_path / "other.txt")) == [5, 6]
    with pytest.raises(NotFoundError, match="poses: expected auto, none, viewpoint or a file"):
        shifts(str(tmp_path / "absent.txt"))


@pytest.mark.parametrize(
    ("said", "complaint"),
    [
        ({"scale": 0.0}, "scale: expected metres per unit, above 0"),
        ({"up": "w"}, "up: expected one of x, -x"),
        ({"delimiter": "##"}, "delimiter: expected one character or comma"),
        ({"columns": "x,y=z"}, "meanings in order or pairs, got both"),
    ],
)
def test_what_is_no_correction_says_what_was_expected(said: dict[str, Any], complaint: str) -> None:
    with pytest.raises(BadInputError, match=complaint):
        parse_corrections(said)


# ── bags ─────────────────────────────────────────────────────────────────────────────────────


def bag(tmp_path: Path, *rows: tuple[str, str, float]) -> Path:
    """A bag of messages (topic, frame id, stamp); x of their points is the stamp's seconds."""
    topics = sorted({topic for topic, _, _ in rows})
    inner = b"".join(
        connection(i, topic.encode(), b"sensor_msgs/PointCloud2") for i, topic in enumerate(topics)
    )
    for topic, frame_id, seconds in rows:
        data = message(seconds, cdr=False).replace(b"lidar", frame_id.encode()[:5].ljust(5))
        number = topics.index(topic).to_bytes(4, "little")
        inner += record(data, op=b"\x02", conn=number, time=stamp(10))
    chunk = record(inner, op=b"\x05", compression=b"none", size=len(inner).to_bytes(4, "little"))
    head = record(bytes(200), op=b"\x03", index_pos=bytes(8), conn_count=bytes(4))
    path = tmp_path / "a.bag"
    path.write_bytes(b"#ROSBAG V2.0\n" + head + chunk)
    return path


def seconds(path: Path, topic: str | None = None) -> list[float]:
    with open_source([path], chosen=Corrections(topic=topic)) as source:
        frames = list(source.frames)
        assert source.count == len(frames)
    return [float(frame.xyz[0, 0]) for frame in frames]


def test_a_topic_is_chosen_and_its_frames_are_in_the_order_of_their_stamps(tmp_path: Path) -> None:
    path = bag(
        tmp_path,
        ("/front", "front", 3), ("/rear", "rears", 7), ("/front", "front", 1),
        ("/front", "front", 2), ("/rear", "rears", 5),
    )  # fmt: skip
    assert seconds(path) == [1, 2, 3]
    assert seconds(path, "/rear") == [5, 7]
    with pytest.raises(BadInputError, match=r"a topic with PointCloud2 \(/front, /rear\)"):
        seconds(path, "/side")


def test_two_sensors_on_one_topic_are_told_apart_by_their_frame_ids(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = bag(
        tmp_path,
        ("/points", "left_", 1), ("/points", "right", 2), ("/points", "left_", 3),
        ("/points", "right", 4), ("/points", "left_", 5),
    )  # fmt: skip
    with caplog.at_level(logging.WARNING):
        assert seconds(path) == [1, 3, 5]
    assert "several sensors publish on /points: 'left_' is read" in caplog.text
    assert "/points#right" in caplog.text
    assert seconds(path, "/points#right") == [2, 4]
    with pytest.raises(BadInputError, match="a sensor of /points: left_, right, got 'top'"):
        seconds(path, "/points#top")


def test_packets_of_a_driver_are_named_as_what_they_are(tmp_path: Path) -> None:
    writer = Writer(cdr=False)
    writer.text("junk")
    inner = connection(0, b"/packets", b"velodyne_msgs/VelodyneScan")
    head = record(bytes(200), op=b"\x03", index_pos=bytes(8), conn_count=bytes(4))
    (tmp_path / "a.bag").write_bytes(b"#ROSBAG V2.0\n" + head + inner)
    with pytest.raises(BadInputError, match=r"VelodyneScan\), packets of a driver: replay them"):
        seconds(tmp_path / "a.bag")
