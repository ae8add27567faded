"""What files mean that can be taken for something else: each reported by people in the field."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats import open_source, read
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.frame import PointFrame

RNG = np.random.default_rng(0)


def frames(path: Path, **options: bool) -> list[PointFrame]:
    return list(read(path, **options))


def one(path: Path) -> PointFrame:
    (frame,) = frames(path)
    return frame


def text(path: Path, content: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content, encoding="utf-8")
    return path


def ply(path: Path, xyz: NDArray[np.float32], **columns: NDArray[np.generic]) -> Path:
    types = {"f4": "float", "u1": "uchar", "u2": "ushort", "i4": "int", "u4": "uint"}
    kinds = [(axis, "<f4") for axis in "xyz"] + [
        (name, values.dtype.newbyteorder("<").str) for name, values in columns.items()
    ]
    rows = np.empty(len(xyz), kinds)
    for i, axis in enumerate("xyz"):
        rows[axis] = xyz[:, i]
    for name, values in columns.items():
        rows[name] = values
    head = "".join(f"property {types[kind[1:]]} {name}\n" for name, kind in kinds)
    path.parent.mkdir(parents=True, exist_ok=True)
    start = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(xyz)}\n"
    path.write_bytes(f"{start}{head}end_header\n".encode() + rows.tobytes())
    return path


def points(n: int = 40) -> NDArray[np.float32]:
    return RNG.uniform(1, 9, (n, 3)).astype(np.float32)


# ── order ────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize(
    "names",
    [
        ["0.0", "0.05", "0.1", "0.15", "0.2"],
        ["-0.5", "-0.05", "0.0", "10.5"],
        ["1616431234.05", "1616431234.1", "1616431234.25"],
        ["scan_9.5", "scan_10.25", "scan_10.3"],
        ["2021-05-01T12-00-00.05Z", "2021-05-01T12-00-00.1Z", "2021-05-01T12-00-01Z"],
        ["1616431234050000000", "1616431234100000000", "1616431234250000000"],
        ["frame2", "frame10", "frame11"],
    ],
)
def test_frames_play_in_the_order_of_their_names_numbers(tmp_path: Path, names: list[str]) -> None:
    for k, name in enumerate(names):
        ply(tmp_path / "rec" / f"{name}.ply", np.full((2, 3), k + 1, np.float32))
    assert [float(frame.xyz[0, 0]) for frame in frames(tmp_path / "rec")] == [
        k + 1 for k in range(len(names))
    ]


# ── colours, normals, labels ─────────────────────────────────────────────────────────────────


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2)])
def test_sixteen_bit_colours_have_one_range_in_a_recording(
    tmp_path: Path, order: tuple[int, ...]
) -> None:
    for place, highest in zip(order, (200, 60_000, 200), strict=True):
        grey = np.full(20, 200, np.uint16)
        grey[-1] = highest
        ply(tmp_path / "rec" / f"{place}.ply", points(20), red=grey, green=grey, blue=grey)
    assert [int(frame.rgb[0, 0]) for frame in frames(tmp_path / "rec")] == [1, 1, 1]


def test_eight_bit_colours_in_sixteen_bits_stay(tmp_path: Path) -> None:
    grey = np.full(20, 200, np.uint16)
    for k in range(3):
        ply(tmp_path / "rec" / f"{k}.ply", points(20), red=grey, green=grey, blue=grey)
    assert [int(frame.rgb[0, 0]) for frame in frames(tmp_path / "rec")] == [200] * 3


def test_fractions_have_one_range_in_a_recording(tmp_path: Path) -> None:
    for k, highest in enumerate((1.0, 250.0)):
        grey = np.full(20, 1.0, np.float32)
        grey[-1] = highest
        ply(tmp_path / "rec" / f"{k}.ply", points(20), red=grey, green=grey, blue=grey)
    assert [int(frame.rgb[0, 0]) for frame in frames(tmp_path / "rec")] == [1, 1]


def test_unit_vectors_are_normals(tmp_path: Path) -> None:
    rows = "".join(f"{x:.3f} {y:.3f} 0 0 0 1\n" for x, y, _ in points())
    assert one(text(tmp_path / "floor.xyz", rows)).rgb is None
    fractions = "".join(f"{x:.3f} {y:.3f} {z:.3f} 0.2 0.4 0.6\n" for x, y, z in points())
    assert one(text(tmp_path / "grey.xyz", fractions)).rgb[0].tolist() == [51, 102, 153]


def test_seven_columns_are_told_apart(tmp_path: Path) -> None:
    xyz = points(300)
    shade = RNG.integers(0, 256, 300)
    rgb = np.clip(RNG.integers(0, 256, 300)[:, None] + RNG.integers(-9, 9, (300, 3)), 0, 255)
    first = "".join(
        f"{p[0]:.3f} {p[1]:.3f} {p[2]:.3f} {i} {c[0]} {c[1]} {c[2]}\n"
        for p, i, c in zip(xyz, shade, rgb, strict=True)
    )
    last = "".join(
        f"{p[0]:.3f} {p[1]:.3f} {p[2]:.3f} {c[0]} {c[1]} {c[2]} {i}\n"
        for p, i, c in zip(xyz, shade % 9, rgb, strict=True)
    )
    frame = one(text(tmp_path / "first.txt", first))
    assert frame.rgb.tolist() == rgb.tolist()
    assert frame.intensity.tolist() == shade.tolist()
    assert one(text(tmp_path / "class.txt", last)).rgb.tolist() == rgb.tolist()


@pytest.mark.parametrize("mark", [-1, -100])
def test_marks_for_no_label_are_unlabeled(tmp_path: Path, mark: int) -> None:
    label = np.array([3, mark, 5] * 10, np.int32)
    frame = one(ply(tmp_path / "a.ply", points(30), label=label, instance=label))
    assert frame.label.tolist() == [3, 0, 5] * 10
    assert frame.instance.tolist() == [3, 0, 5] * 10


@pytest.mark.parametrize(("kind", "mark"), [(np.uint16, 65535), (np.uint32, 4294967295)])
def test_greatest_numbers_mark_no_label(tmp_path: Path, kind: type, mark: int) -> None:
    frame = one(ply(tmp_path / "a.ply", points(30), label=np.array([3, mark, 5] * 10, kind)))
    assert frame.label.tolist() == [3, 0, 5] * 10
    with pytest.raises(BadInputError, match="expected labels 0 to 65534"):
        one(ply(tmp_path / "b.ply", points(3), label=np.array([3, -7, 5], np.int32)))


def test_tags_are_labels_and_unknown_ones_are_named(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    tag = np.arange(30, dtype=np.uint32) % 7
    assert one(ply(tmp_path / "a.ply", points(30), ObjTag=tag)).label.tolist() == tag.tolist()
    with caplog.at_level(logging.WARNING):
        assert one(ply(tmp_path / "b.ply", points(30), my_semantic_code=tag)).label is None
    assert "my_semantic_code" in caplog.text


# ── text ─────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize(
    "content",
    [
        "X;Y;Z\n1,5;2,25;3,125\n-4,0;5,5;6,0\n",
        "1,5\t2,25\t3,125\n-4,0\t5,5\t6,0\n",
        "1,5 2,25 3,125\n-4,0 5,5 6,0\n",
        "1.5, 2.25, 3.125\n-4.0, 5.5, 6.0\n",
    ],
)
def test_decimal_commas(tmp_path: Path, content: str) -> None:
    frame = one(text(tmp_path / "a.csv", content))
    assert frame.xyz.tolist() == [[1.5, 2.25, 3.125], [-4.0, 5.5, 6.0]]


def test_columns_of_words_are_left_out(tmp_path: Path) -> None:
    rows = 'name,when,x,y,z,remark\n"a, b",2021-05-01 12:00:00.1,1,2,3,\nc,2021-05-01,4,5,6,far\n'
    assert one(text(tmp_path / "a.csv", rows)).xyz.tolist() == [[1, 2, 3], [4, 5, 6]]
    plain = one(text(tmp_path / "b.txt", "1 2 3 car\n4 5 6 tree\n"))
    assert plain.xyz.tolist() == [[1, 2, 3], [4, 5, 6]]
    with pytest.raises(BadInputError, match="line 3: expected a number"):
        one(text(tmp_path / "c.csv", "x,y,z,name\n1,2,3,a\n4,five,6,b\n"))


def test_a_header_before_the_count_of_a_pts(tmp_path: Path) -> None:
    rows = "//X;Y;Z;Intensity\n2\n1;2;3;0.5\n4;5;6;0.25\n"
    frame = one(text(tmp_path / "a.pts", rows))
    assert frame.xyz.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert frame.intensity.tolist() == [0.5, 0.25]
    with pytest.raises(BadInputError, match="expected 3 points as line 2 says, got 2"):
        one(text(tmp_path / "b.pts", rows.replace("\n2\n", "\n3\n")))


def test_windows_words_for_nan(tmp_path: Path) -> None:
    head = "ply\nformat ascii 1.0\nelement vertex 2\n" + "".join(
        f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz")
    )
    rows = "end_header\n1 2 3 -1.#IND 1.#QNAN -nan(ind)\n4 5 6 0 1 0\n"
    assert one(text(tmp_path / "a.ply", head + rows)).xyz.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert one(text(tmp_path / "a.xyz", "1 2 3 1.#INF\n4 5 6 7\n")).intensity.tolist() == [0, 7]


# ── points that are none, records of other widths ────────────────────────────────────────────


def pcd(path: Path, xyz: NDArray[np.float32]) -> Path:
    head = (
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {len(xyz)}\nHEIGHT 1\nPOINTS {len(xyz)}\nDATA binary\n"
    )
    path.write_bytes(head.encode() + xyz.tobytes())
    return path


def npy(path: Path, xyz: NDArray[np.float32]) -> Path:
    np.save(path, xyz)
    return path


def csv(path: Path, xyz: NDArray[np.float32]) -> Path:
    return text(path, "x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in xyz.tolist()))


def raw(path: Path, xyz: NDArray[np.float32]) -> Path:
    rows = np.c_[xyz, np.where(xyz.any(axis=1), 0.5, 0)].astype("<f4")
    path.write_bytes(rows.tobytes())
    return path


@pytest.mark.parametrize(
    ("write", "ending"),
    [
        *((pcd, "pcd"), (ply, "ply"), (npy, "npy"), (csv, "csv"), (raw, "bin")),
    ],
)
def test_beams_without_an_echo_are_left_out_and_counted(
    tmp_path: Path, write: Callable[[Path, NDArray[np.float32]], Path], ending: str
) -> None:
    xyz = points(100)
    xyz[::2] = 0
    frame = one(write(tmp_path / f"a.{ending}", xyz))
    assert (len(frame), frame.dropped) == (50, 50)
    assert frame.rows is not None
    assert frame.rows.tolist() == list(range(1, 100, 2))
    xyz = points(10)
    xyz[3] = 0
    assert len(one(write(tmp_path / f"b.{ending}", xyz))) == 10


def test_an_empty_bin_among_others_is_a_moment_without_points(tmp_path: Path) -> None:
    for k in range(3):
        path = tmp_path / "rec" / "velodyne" / f"{k:06d}.bin"
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = np.c_[points(), np.ones(40)].astype("<f4")
        path.write_bytes(b"" if k == 1 else rows.tobytes())
    assert [len(frame) for frame in frames(tmp_path / "rec")] == [40, 0, 40]
    with pytest.raises(BadInputError, match="empty file"):
        frames(tmp_path / "rec" / "velodyne" / "000001.bin")


@pytest.mark.parametrize("width", [5, 6, 7])
@pytest.mark.parametrize("count", [399, 400])
def test_bin_records_of_more_floats_are_told_by_their_values(
    tmp_path: Path, width: int, count: int
) -> None:
    xyz = RNG.uniform(-50, 50, (count, 3))
    wide = [xyz, RNG.integers(0, 256, count)[:, None], RNG.integers(0, 32, count)[:, None]]
    wide += [RNG.uniform(0, 0.1, (count, width - 5))]
    rows = np.concatenate(wide, axis=1).astype("<f4")
    (tmp_path / "a.bin").write_bytes(rows.tobytes())
    frame = one(tmp_path / "a.bin")
    assert np.array_equal(frame.xyz, rows[:, :3])
    assert np.array_equal(frame.intensity, rows[:, 3])


def test_nuscenes_sweeps_have_five_floats_wherever_they_lie(tmp_path: Path) -> None:
    rows = np.c_[points(400), RNG.integers(0, 99, 400), RNG.integers(0, 32, 400)].astype("<f4")
    path = tmp_path / "velodyne" / "n015__LIDAR_TOP__1532402927647951.pcd.bin"
    path.parent.mkdir()
    path.write_bytes(rows.tobytes())
    assert np.array_equal(one(path).xyz, rows[:, :3])


def test_poses_beside_frames_of_any_format(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    for k in range(2):
        ply(tmp_path / "run" / f"{k}.ply", points())
    line = "1 0 0 {} 0 1 0 0 0 0 1 0\n"
    text(tmp_path / "run" / "poses.txt", line.format(0) + line.format(2))
    assert [float(frame.pose[0, 3]) for frame in frames(tmp_path / "run")] == [0, 2]
    text(tmp_path / "run" / "poses.txt", "no poses\n")
    with caplog.at_level(logging.WARNING):
        assert [frame.pose for frame in frames(tmp_path / "run")] == [None, None]
    assert "poses are not used" in caplog.text


def test_npz_points_are_never_the_colours(tmp_path: Path) -> None:
    coord, color = points(), RNG.integers(0, 256, (40, 3))
    segment = RNG.integers(-1, 5, 40)
    np.savez(tmp_path / "a.npz", coord=coord, color=color, segment=segment)
    frame = one(tmp_path / "a.npz")
    assert np.array_equal(frame.xyz, coord)
    assert frame.rgb.tolist() == color.tolist()
    assert frame.label.tolist() == np.maximum(segment, 0).tolist()
    np.savez(tmp_path / "b.npz", unknown=coord, color=color)
    with pytest.raises(BadInputError, match="expected an array 'xyz' or 'points', got unknown"):
        one(tmp_path / "b.npz")


@pytest.mark.parametrize("width", [5, 6, 7])
def test_records_of_radar_are_read_by_their_columns(tmp_path: Path, width: int) -> None:
    # x y z RCS v_r v_r_compensated time, in folders called as KITTI's (View-of-Delft).
    rng = np.random.default_rng(0)
    spread, middle = [15, 8, 1, 9, 2, 2, 0], [25, 0, 0, -12, 0, 0, 0]
    table = rng.normal(middle[:width], spread[:width], (160, width)).astype("<f4")
    path = tmp_path / "velodyne" / "0.bin"
    path.parent.mkdir()
    path.write_bytes(table.tobytes())
    with pytest.raises(BadInputError, match=r"name the format .* or all columns in order"):
        next(read(path))
    columns = ("x", "y", "z", "rcs", "v_r", "v_r_comp", "time")[:width]
    with open_source([path], chosen=Corrections(columns=columns)) as source:
        (frame,) = source.frames
    assert np.array_equal(frame.xyz, table[:, :3])
    assert list(frame.other) == list(columns[3:])
    assert np.array_equal(frame.other["v_r"], table[:, 4])
    path.write_bytes(table.tobytes()[:-4])
    with (
        open_source([path], chosen=Corrections(columns=columns)) as source,
        pytest.raises(BadInputError, match=f"records of {4 * width} bytes"),
    ):
        next(source.frames)


@pytest.mark.parametrize("name", ["00.pkl.gz", "lidar/00.pkl.gz", "lidar/00.pickle"])
def test_pickles_are_refused_with_a_way_out(tmp_path: Path, name: str) -> None:
    path = tmp_path / "pandaset" / name
    path.parent.mkdir(parents=True)
    path.write_bytes(b"cos\nsystem\n(S'exit 1'\ntR.")
    for place in (tmp_path / "pandaset", path):
        with pytest.raises(BadInputError, match=r"PandaSet, run code .*to_feather"):
            open_source([place])


def test_labels_in_words_have_the_same_number_in_all_files(tmp_path: Path) -> None:
    (tmp_path / "0.csv").write_text("x,y,z,class,note\n1,2,3,tree,a\n4,5,6,car,b\n7,8,9,,c\n")
    (tmp_path / "1.csv").write_text("x,y,z,class,note\n1,2,3,car,a\n4,5,6,Unlabeled,b\n")
    with open_source([tmp_path]) as source:
        labels = [None if f.label is None else f.label.tolist() for f in source.frames]
    assert labels == [[1, 2, 0], [2, 0]]
    assert source.classes == ["tree", "car"]


def test_a_column_of_texts_is_no_column_of_classes(tmp_path: Path) -> None:
    rows = "".join(f"{k},0,1,note {k}\n" for k in range(5000))
    (tmp_path / "a.csv").write_text("x,y,z,label\n" + rows)
    with pytest.raises(BadInputError, match=r"a\.csv: expected at most 4096 class names"):
        next(read(tmp_path / "a.csv"))


def test_left_handed_axes_of_carla_are_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    fields = ("float32 x", "float32 y", "float32 z", "float32 CosAngle", "uint32 ObjIdx")
    head = "".join(f"property {field}\n" for field in (*fields, "uint32 ObjTag"))
    text = f"ply\nformat ascii 1.0\nelement vertex 1\n{head}end_header\n1 2 3 0.5 7 10\n"
    (tmp_path / "a.ply").write_text(text)
    (frame,) = read(tmp_path / "a.ply")
    assert frame.label is not None
    assert "CARLA's axes are left-handed" in caplog.text


def test_messages_of_rostopic_echo_are_called_so(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("header: \n  seq: 1\nx: 0.5\ny: 1.0\nz: 0.0\n---\n")
    with pytest.raises(BadInputError, match="got messages as 'rostopic echo' prints them"):
        next(read(tmp_path / "a.txt"))
