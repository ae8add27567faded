"""PLY: every layout, against the independent reader plyfile."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from plyfile import PlyData, PlyElement

from pointbrush.errors import BadInputError
from pointbrush.formats import read
from pointbrush.formats.readers.ply import write_ply
from pointbrush.formats.tables.table import Table

CUBE = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]


def one(path: Path, **kwargs):
    (frame,) = read(path, **kwargs)
    return frame


def header(*lines: str, layout: str = "ascii") -> bytes:
    return "\n".join(["ply", f"format {layout} 1.0", *lines, "end_header", ""]).encode()


@pytest.mark.parametrize(("text", "byte_order"), [(True, "="), (False, "<"), (False, ">")])
def test_reads_any_order_and_type_of_properties(tmp_path, text, byte_order):
    kinds = {"blue": "u1", "z": "f4", "extra": "f8", "red": "u1", "x": "f4", "green": "u1"}
    kinds |= {"y": "f4", "label": "i4", "intensity": "u2"}
    rows = np.zeros(4, list(kinds.items()))
    for axis, column in zip("xyz", np.array(CUBE).T, strict=True):
        rows[axis] = column
    rows["red"], rows["green"], rows["blue"] = 1, 2, 3
    rows["label"], rows["intensity"] = [0, 7, 300, 65534], [1, 2, 3, 40000]
    faces = np.array([([0, 1, 2],), ([1, 2, 3],)], [("vertex_indices", "i4", (3,))])
    elements = [PlyElement.describe(faces, "face"), PlyElement.describe(rows, "vertex")]
    PlyData(elements, text=text, byte_order=byte_order).write(tmp_path / "a.ply")
    frame = one(tmp_path / "a.ply")
    assert frame.xyz.tolist() == np.array(CUBE, float).tolist()
    assert frame.rgb.tolist() == [[1, 2, 3]] * 4
    assert frame.label.tolist() == [0, 7, 300, 65534]
    assert frame.intensity.tolist() == [1, 2, 3, 40000]


@pytest.mark.parametrize("layout", ["ascii", "binary_little_endian"])
def test_lists_within_vertices_are_passed_over(tmp_path, layout):
    head = header(
        *("element vertex 2", "property float x", "property list uchar int ids"),
        *("property float y", "property float z"),
        layout=layout,
    )
    if layout == "ascii":
        body = b"1 3 7 8 9 2 3\n4 0 5 6\n"
    else:
        body = np.float32(1).tobytes() + b"\x03" + np.array([7, 8, 9], "<i4").tobytes()
        body += np.array([2, 3, 4], "<f4").tobytes() + b"\0" + np.array([5, 6], "<f4").tobytes()
    (tmp_path / "a.ply").write_bytes(head + body)
    assert one(tmp_path / "a.ply").xyz.tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    ("kind", "value", "expected"),
    [("float", 0.5, 128), ("float", 200.0, 200), ("ushort", 65535, 255), ("ushort", 200, 200)],
)
def test_colours_of_other_types_become_8_bit(tmp_path, kind, value, expected):
    names = ("red", "green", "blue")
    head = header(
        "element vertex 1", *(f"property float {axis}" for axis in "xyz"),
        *(f"property {kind} diffuse_{name}" for name in names),
    )  # fmt: skip
    (tmp_path / "a.ply").write_bytes(head + f"0 0 0 {value} {value} {value}\n".encode())
    assert one(tmp_path / "a.ply").rgb.tolist() == [[expected] * 3]


def test_text_far_from_the_origin_keeps_its_digits(tmp_path):
    head = header("element vertex 1", *(f"property float {axis}" for axis in "xyz"))
    (tmp_path / "a.ply").write_bytes(head + b"289814.15 4320978.61 170.76\n")
    x, y, z = one(tmp_path / "a.ply").xyz[0].tolist()
    assert (x, y) == (289814.15, 4320978.61)
    assert z == np.float32(170.76)


XYZ = tuple(f"property float {axis}" for axis in "xyz")
BAD = {
    "empty": (b"", "empty file"),
    "magic": (b"solid cube", "'ply'"),
    "header cut off": (b"ply\nformat ascii 1.0\nelement vertex", "end_header"),
    "no vertex": (header("element face 0", "property list uchar int v"), "'vertex'"),
    "no z": (header("element vertex 1", *XYZ[:2]) + b"1 2\n", "x, y and z"),
    "odd names": (header("element vertex 1", "property float xyz") + b"1\n", "x, y and z"),
    "type": (header("element vertex 1", "property quad x"), "line 4"),
    "float count": (header("element vertex 1", "property list float int v"), "line 4"),
    "ascii cut off": (header("element vertex 2", *XYZ) + b"1 2 3\n4 5\n", "cut off"),
    "ascii word": (
        header("element vertex 1", *XYZ) + b"1 2 three\n",
        "data line 1",
    ),
    "ascii too large": (
        header("element vertex 1", *XYZ, "property uchar red") + b"1 2 3 256\n",
        "uint8",
    ),
    "binary cut off": (
        header("element vertex 2", *XYZ, layout="binary_little_endian") + bytes(23),
        "cut off",
    ),
    "claims billions": (
        header("element vertex 400000000", *XYZ, layout="binary_little_endian") + bytes(24),
        "cut off",
    ),
    "list longer than the file": (
        header(
            *("element face 1", "property list uint int v", "element vertex 0", *XYZ),
            layout="binary_big_endian",
        )
        + b"\xff\xff\xff\xff\0",
        "cut off",
    ),
    "negative list": (
        header("element vertex 1", *XYZ, "property list char int v") + b"1 2 3 -4\n",
        "length of a list",
    ),
    "NaN": (header("element vertex 2", *XYZ) + b"1 2 3\n1 nan 3\n", "first at point 1"),
    "label": (header("element vertex 1", *XYZ, "property int label") + b"1 2 3 70000\n", "label"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_files_say_what_was_expected(tmp_path, case):
    data, message = BAD[case]
    (tmp_path / "bad.ply").write_bytes(data)
    with pytest.raises(BadInputError, match=r"bad\.ply.*expected") as caught:
        one(tmp_path / "bad.ply")
    assert message in str(caught.value)


def test_every_truncation_of_a_binary_file_raises(tmp_path):
    out = io.BytesIO()
    write_ply(out, Table.of({axis: np.arange(5, dtype=np.float32) for axis in "xyz"}))
    for size in range(len(out.getvalue())):
        (tmp_path / "a.ply").write_bytes(out.getvalue()[:size])
        with pytest.raises(BadInputError):
            one(tmp_path / "a.ply")


def test_invalid_points_can_be_left_out(tmp_path):
    head = header("element vertex 3", *XYZ, "property ushort label")
    (tmp_path / "a.ply").write_bytes(head + b"1 2 3 5\nnan 2 3 6\n7 8 9 7\n")
    frame = one(tmp_path / "a.ply", drop_invalid=True)
    assert frame.dropped == 1
    assert frame.label.tolist() == [5, 7]


finite = {
    width: st.floats(allow_nan=False, allow_infinity=False, width=width) for width in (32, 64)
}


@given(st.data(), st.sampled_from([np.float32, np.float64]), st.integers(0, 30))
def test_what_is_written_reads_back_bit_for_bit(tmp_path_factory, data, dtype, count):
    elements = finite[np.dtype(dtype).itemsize * 8]
    xyz = data.draw(hnp.arrays(dtype, (count, 3), elements=elements))
    rgb = data.draw(hnp.arrays(np.uint8, (count, 3)))
    label = data.draw(hnp.arrays(np.uint16, count, elements=st.integers(0, 65534)))
    columns = {axis: xyz[:, i] for i, axis in enumerate("xyz")}
    columns |= {name: rgb[:, i] for i, name in enumerate(("red", "green", "blue"))}
    columns["label"] = label
    path = tmp_path_factory.mktemp("ply") / "a.ply"
    with path.open("wb") as file:
        write_ply(file, Table.of(columns))
    frame = one(path)
    assert frame.xyz.dtype == dtype
    kept = np.arange(count) if frame.rows is None else frame.rows  # several at 0 0 0 are not
    assert frame.xyz.tobytes() == xyz[kept].tobytes()
    assert np.array_equal(frame.rgb, rgb[kept])
    assert np.array_equal(frame.label, label[kept])
    independent = PlyData.read(path)["vertex"]
    assert np.array_equal(independent["label"], label)
    assert independent["y"].tobytes() == xyz[:, 1].tobytes()
