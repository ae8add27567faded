"""PCD: three layouts, packed colours, missing pixels."""

from __future__ import annotations

import contextlib
import io
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats import open_source, read, reported
from pointbrush.formats.readers.lzf import lzf_decompress
from pointbrush.formats.readers.pcd import write_pcd
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.formats.tables.table import Table

COLOR = 0xFF102030


def one(path: Path, **kwargs):
    (frame,) = read(path, **kwargs)
    return frame


def header(layout: str, points: int, fields: str = "x y z", kinds: str = "F F F", **more) -> bytes:
    count = len(fields.split())
    lines = {
        "VERSION": "0.7",
        "FIELDS": fields,
        "SIZE": " ".join(["4"] * count),
        "TYPE": kinds,
        "COUNT": " ".join(["1"] * count),
        "WIDTH": points,
        "HEIGHT": 1,
        "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": points,
        **more,
        "DATA": layout,
    }
    return "".join(f"{key} {value}\n" for key, value in lines.items()).encode()


def stored(data: bytes) -> bytes:
    """LZF that uses literal runs only."""
    return b"".join(
        bytes([len(data[i : i + 32]) - 1]) + data[i : i + 32] for i in range(0, len(data), 32)
    )


@pytest.mark.parametrize("layout", ["ascii", "binary", "binary_compressed"])
@pytest.mark.parametrize("kind", ["U", "F"])
def test_packed_colours_in_every_layout(tmp_path, layout, kind):
    xyz = np.array([[1, 2, 3], [4, 5, 6]], "<f4")
    color = np.array([0x00102030, 0x00FF8000], "<u4")
    number = color.view("<f4") if kind == "F" else color
    if layout == "ascii":
        body = "".join(
            f"{x} {y} {z} {c!s}\n" for (x, y, z), c in zip(xyz, number, strict=True)
        ).encode()
    elif layout == "binary":
        rows = np.empty(2, [("p", "<f4", 3), ("c", "<u4")])
        rows["p"], rows["c"] = xyz, color
        body = rows.tobytes()
    else:
        raw = xyz.T.tobytes() + color.tobytes()
        body = struct.pack("<II", len(stored(raw)), len(raw)) + stored(raw)
    head = header(layout, 2, "x y z rgb", f"F F F {kind}")
    (tmp_path / "a.pcd").write_bytes(head + body)
    frame = one(tmp_path / "a.pcd")
    assert frame.xyz.tolist() == xyz.tolist()
    assert frame.rgb.tolist() == [[0x10, 0x20, 0x30], [0xFF, 0x80, 0x00]]


def test_alpha_that_makes_a_packed_float_nan_keeps_the_colour(tmp_path):
    rows = np.empty(1, [("p", "<f4", 3), ("c", "<u4")])
    rows["p"], rows["c"] = 1, COLOR
    (tmp_path / "a.pcd").write_bytes(header("binary", 1, "x y z rgb", "F F F F") + rows.tobytes())
    assert one(tmp_path / "a.pcd").rgb.tolist() == [[0x10, 0x20, 0x30]]


def test_missing_pixels_are_counted_and_values_stay_aligned(tmp_path):
    head = header(
        "ascii", 4, "x y z label", "F F F U", WIDTH=2, HEIGHT=2, VIEWPOINT="1 2 3 1 0 0 0"
    )
    (tmp_path / "a.pcd").write_bytes(head + b"1 1 1 1\nnan nan nan 2\n3 3 3 3\n4 nan 4 4\n")
    frame = one(tmp_path / "a.pcd")
    assert (len(frame), frame.dropped) == (2, 2)
    assert frame.label.tolist() == [1, 3]
    assert frame.viewpoint.tolist() == [1, 2, 3]


BAD = {
    "empty": (b"", "empty"),
    "no header": (b"1 2 3\n4 5 6\n", "header line"),
    "header cut off": (b"VERSION 0.7\nFIELDS x y z\n", "DATA"),
    "layout": (header("morse", 1), "DATA ascii"),
    "points": (header("ascii", 2, POINTS=3) + b"1 2 3\n4 5 6\n", "WIDTH x HEIGHT"),
    "negative": (header("ascii", 1, WIDTH=-1), "WIDTH"),
    "sizes": (header("ascii", 1, SIZE="4 4"), "one entry per field"),
    "size 3": (header("ascii", 1, SIZE="4 4 3"), "'z'"),
    "viewpoint": (header("ascii", 1, VIEWPOINT="0 0 0"), "VIEWPOINT"),
    "too few": (header("ascii", 2) + b"1 2 3\n", "6 numbers"),
    "too many": (header("ascii", 1) + b"1 2 3\n4 5 6\n", "3 numbers"),
    "binary cut off": (header("binary", 2) + bytes(20), "cut off"),
    "compressed cut off": (header("binary_compressed", 2) + struct.pack("<II", 90, 24), "cut off"),
    "compressed size": (header("binary_compressed", 2) + struct.pack("<II", 2, 25), "24 bytes"),
    "compressed garbage": (
        header("binary_compressed", 2) + struct.pack("<II", 4, 24) + b"\xe0\xff\xff\xff",
        "damaged",
    ),
    "no z": (header("ascii", 1, "x y w") + b"1 2 3\n", "x, y and z"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_files_say_what_was_expected(tmp_path, case):
    data, message = BAD[case]
    (tmp_path / "bad.pcd").write_bytes(data)
    with pytest.raises(BadInputError, match=r"bad\.pcd.*expected") as caught:
        one(tmp_path / "bad.pcd")
    assert message in str(caught.value)


def test_a_count_beyond_the_limit_is_too_large(tmp_path):
    (tmp_path / "a.pcd").write_bytes(header("binary", 10**12))
    with pytest.raises(TooLargeError, match="points"):
        one(tmp_path / "a.pcd")


def encode(data: bytes) -> bytes:
    """A greedy LZF encoder, for the round trip."""
    out, literals, at = bytearray(), bytearray(), 0
    last: dict[bytes, int] = {}

    def flush():
        for start in range(0, len(literals), 32):
            run = literals[start : start + 32]
            out.extend([len(run) - 1, *run])
        literals.clear()

    while at < len(data):
        key = data[at : at + 3]
        start = last.get(key)
        last[key] = at
        if start is None or len(key) < 3 or at - start > 8192:
            literals.append(data[at])
            at += 1
            continue
        length = 3
        while (
            length < 264 and at + length < len(data) and data[start + length] == data[at + length]
        ):
            length += 1
        flush()
        distance, short = at - start - 1, length - 2
        out.append(min(short, 7) << 5 | distance >> 8)
        if short >= 7:
            out.append(short - 7)
        out.append(distance & 255)
        at += length
    flush()
    return bytes(out)


@given(st.lists(st.tuples(st.binary(max_size=40), st.integers(1, 30)), max_size=12))
def test_lzf_round_trip(parts):
    data = b"".join(part * times for part, times in parts)
    assert lzf_decompress("a", encode(data), len(data)) == data


@given(st.binary(max_size=80), st.integers(0, 300))
def test_lzf_garbage_raises_or_fills_the_size(data, size):
    with contextlib.suppress(BadInputError):
        assert len(lzf_decompress("a", data, size)) == size


def test_written_files_read_back(tmp_path):
    xyz = np.random.default_rng(1).normal(size=(50, 3))
    label = np.arange(50, dtype=np.uint16)
    columns = {axis: xyz[:, i] for i, axis in enumerate("xyz")}
    columns |= {"rgba": np.full(50, COLOR, np.uint32), "label": label}
    out = io.BytesIO()
    write_pcd(out, Table.of(columns))
    (tmp_path / "a.pcd").write_bytes(out.getvalue())
    frame = one(tmp_path / "a.pcd")
    assert frame.xyz.tobytes() == xyz.tobytes()
    assert np.array_equal(frame.label, label)
    assert frame.rgb[7].tolist() == [0x10, 0x20, 0x30]


def test_a_real_kinect_recording(shared):
    frames = list(read(shared / "realdata" / "pcl_kinect3"))
    assert [len(frame) + frame.dropped for frame in frames] == [640 * 480] * 3
    assert all(frame.rgb.std() > 20 for frame in frames)


@pytest.mark.parametrize("layout", ["ascii", "binary", "binary_compressed"])
def test_padding_fields_also_of_no_values_are_passed_over(tmp_path: Path, layout: str) -> None:
    rows = np.zeros(5, [("xyz", "<f4", 3), ("pad", "u1", 4), ("ring", "<u2"), ("_", "<f4")])
    rows["xyz"], rows["ring"] = np.arange(15).reshape(5, 3), np.arange(5)
    body = {
        "binary": rows.tobytes(),
        "ascii": "".join(f"{r['xyz']} 1 2 3 4 {r['ring']} 9\n" for r in rows).encode(),
    }
    body["ascii"] = body["ascii"].replace(b"[", b"").replace(b"]", b"")
    columns = [rows["xyz"].T, rows["pad"], rows["ring"], rows["_"]]
    raw = b"".join(np.ascontiguousarray(column).tobytes() for column in columns)
    packed = stored(raw)
    body["binary_compressed"] = struct.pack("<II", len(packed), len(raw)) + packed
    head = header(
        layout,
        5,
        "x y z _ _ ring _ _",
        "F F F U F U F F",
        SIZE="4 4 4 1 4 2 4 4",
        COUNT="1 1 1 4 0 1 1 0",
    )
    (tmp_path / "a.pcd").write_bytes(head + body[layout])
    frame = one(tmp_path / "a.pcd")
    assert frame.xyz.tolist() == rows["xyz"].tolist()
    assert {name: values.tolist() for name, values in frame.other.items()} == {
        "ring": [0, 1, 2, 3, 4]
    }


def test_objects_of_hitachis_editor_are_instances_from_0(tmp_path: Path) -> None:
    head = header("ascii", 3, "x y z label object", "F F F I I")
    (tmp_path / "a.pcd").write_bytes(head + b"1 1 1 4 0\n2 2 2 4 1\n3 3 3 1 -1\n")
    frame = one(tmp_path / "a.pcd")
    assert frame.label.tolist() == [4, 4, 1]
    assert frame.instance.tolist() == [1, 2, 0]


TURNED = "1 2 3 0.7071067811865476 0 0 0.7071067811865476"
"""A place, and a quarter turn about z, w first."""


def placed(folder: Path, viewpoints: list[str]) -> Path:
    for number, viewpoint in enumerate(viewpoints):
        data = header("ascii", 2, VIEWPOINT=viewpoint) + b"1 0 0\n2 0 0\n"
        (folder / f"{number}.pcd").write_bytes(data)
    return folder


@pytest.mark.parametrize("viewpoint", [TURNED, "0 0 2 1 0 0 0", "0 0 0 0 1 0 0"])
def test_a_viewpoint_that_places_a_cloud_is_named_or_used(tmp_path, viewpoint):
    folder = placed(tmp_path, ["0 0 0 1 0 0 0", viewpoint, viewpoint])
    with reported() as warnings:
        frames = list(read(folder))
    assert all(frame.pose is None for frame in frames)
    assert [frame.xyz.tolist() for frame in frames] == [[[1, 0, 0], [2, 0, 0]]] * 3
    (said,) = warnings
    assert "VIEWPOINT" in said
    assert "the points are not moved; poses 'viewpoint' moves the points by it" in said
    with reported() as warnings, open_source([folder], chosen=Corrections(poses="viewpoint")) as s:
        first, second, _ = s.frames
    assert not warnings
    assert first.pose.tolist() == np.eye(4).tolist()
    assert second.pose[:3, 3].tolist() == [float(word) for word in viewpoint.split()[:3]]
    assert second.viewpoint.tolist() == [0, 0, 0]
    if viewpoint == TURNED:
        assert (second.pose @ [1, 0, 0, 1]).tolist() == pytest.approx([1, 3, 3, 1])


@pytest.mark.parametrize("viewpoint", ["0 0 0 1 0 0 0", "0 0 0 -1 0 0 0", "0 0 0 0 0 0 0"])
def test_a_viewpoint_that_places_nothing_is_not_named(tmp_path, viewpoint):
    with reported() as warnings:
        list(read(placed(tmp_path, [viewpoint])))
    assert not warnings
