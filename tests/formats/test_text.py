"""Text: separators, headers, columns without names, count lines."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pointbrush.errors import BadInputError
from pointbrush.formats import open_source, read, reported
from pointbrush.formats.readers import text
from pointbrush.formats.readers.text import write_csv
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.formats.tables.table import Table


def one(path, text, **kwargs):
    path.write_bytes(text.encode())
    (frame,) = read(path, **kwargs)
    return frame


@pytest.mark.parametrize("separator", [" ", "   ", "\t", ",", ", ", ";", " , "])
@pytest.mark.parametrize("header", [None, ["X", "Y", "Z", "Intensity"], ['"x"', '"y"', '"z"', "i"]])
@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_separators_headers_and_line_ends(tmp_path, separator, header, line_end):
    rows = [["1.5", "-2", "3e1", "7"], ["4", "5", "6", "8"]]
    lines = [separator.join(row) for row in ([header] if header else []) + rows]
    frame = one(tmp_path / "a.txt", line_end.join(["", *lines, ""]))
    assert frame.xyz.tolist() == [[1.5, -2, 30], [4, 5, 6]]
    assert frame.intensity.tolist() == [7, 8]


@pytest.mark.parametrize(
    ("name", "line", "rgb", "intensity"),
    [
        ("a.xyz", "1 2 3 255 0 7", [255, 0, 7], None),
        ("a.xyz", "1 2 3 1.0 0.0 0.5", [255, 0, 128], None),
        ("a.xyz", "1 2 3 0.0 -1.0 0.5", None, None),
        ("a.xyz", "1 2 3 -1613 52 70 64", [52, 70, 64], -1613),
        ("a.pts", "1 2 3 9 52 70 64", [52, 70, 64], 9),
        ("a.pts", "1\n1 2 3 9 52 70 64", [52, 70, 64], 9),
        ("a.xyz", "1 2 3 52 70 64 255.0", [52, 70, 64], None),
        ("a.asc", "//X Y Z R G B\n1 2 3 52 70 64", [52, 70, 64], None),
        ("a.csv", "label,z,y,x\n4,3,2,1", None, None),
    ],
)
def test_columns_by_number_and_content(tmp_path, name, line, rgb, intensity):
    frame = one(tmp_path / name, line)
    assert frame.xyz.tolist() == [[1, 2, 3]]
    assert (None if frame.rgb is None else frame.rgb[0].tolist()) == rgb
    assert (None if frame.intensity is None else frame.intensity[0]) == intensity


VALUES = [[1.5, -2.25, 3000.125, 7], [4, 5.5, 6, 8]]


@pytest.mark.parametrize(
    "header",
    [
        *("x [m],y [m],z [m],intensity [-]", "X(m),Y(m),Z(m),Intensity", "x / m,y / m,z / m,i"),
        *("x m,y m,z m,i", "X_m,Y_m,Z_m,i", '"x [m]","y [m]","z [m]","i [counts]"'),
    ],
)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_units_in_a_header_are_no_part_of_its_names(
    tmp_path: Path, header: str, separator: str
) -> None:
    rows = [separator.join(map(str, row)) for row in VALUES]
    frame = one(tmp_path / "a.csv", "\n".join([header.replace(",", separator), *rows]))
    assert np.c_[frame.xyz, frame.intensity].tolist() == VALUES
    assert not frame.other


def test_units_between_spaces_are_no_columns(tmp_path: Path) -> None:
    rows = [" ".join(map(str, row)) for row in VALUES]
    frame = one(tmp_path / "a.txt", "\n".join(["x [m] y [m] z (m) i", *rows]))
    assert np.c_[frame.xyz, frame.intensity].tolist() == VALUES


def test_another_unit_than_metres_is_named(tmp_path: Path) -> None:
    body = "x [mm],y [mm],z [mm]\n1,2,3\n"
    with reported() as warnings:
        assert one(tmp_path / "a.csv", body).xyz.tolist() == [[1, 2, 3]]
    assert list(warnings) == ["the header gives coordinates in mm: scale 0.001 makes them metres"]
    with reported() as warnings, open_source([tmp_path], chosen=Corrections(scale=0.001)) as source:
        assert next(source.frames).xyz.tolist() == [[0.001, 0.002, 0.003]]
    assert not warnings


def test_a_name_that_is_whole_goes_before_one_with_a_unit(tmp_path: Path) -> None:
    frame = one(tmp_path / "a.csv", "x [px],x,y,z,class (old)\n9,1,2,3,4\n")
    assert frame.xyz.tolist() == [[1, 2, 3]]
    assert frame.label is None


@pytest.mark.parametrize("first", ["", "sep=;\n"])
@pytest.mark.parametrize(
    ("separator", "quote"), [(";", ""), ("\t", ""), (" ", ""), (",", '"'), (";", '"')]
)
@pytest.mark.parametrize("whole", [0, 60])
def test_decimal_commas(tmp_path: Path, separator: str, quote: str, whole: int, first: str) -> None:
    def line(row: list[float]) -> str:
        return separator.join(f"{quote}{str(v).replace('.', ',')}{quote}" for v in row)

    rows = [*[[1, 2, 3, 4]] * whole, *VALUES]
    head = separator.join(["x", "y", "z", "i"])
    frame = one(tmp_path / "a.csv", first + "\n".join([head, *map(line, rows)]))
    assert np.c_[frame.xyz, frame.intensity].tolist() == rows


def test_decimal_commas_between_spaces_beside_a_word(tmp_path: Path) -> None:
    frame = one(tmp_path / "a.txt", "1,5 2,25 3,125 tree\n4,0 5,5 6,0 pole\n")
    assert frame.xyz.tolist() == [[1.5, 2.25, 3.125], [4, 5.5, 6]]


@pytest.mark.parametrize("counts", [(2, 1), (1, 0, 3), (0, 2)])
def test_points_of_all_scans_of_a_file_are_read(tmp_path: Path, counts: tuple[int, ...]) -> None:
    scans = [
        "".join([f"{count}\r\n", *(f"{k} {i} 3 -800 52 70 64\r\n" for i in range(count))])
        for k, count in enumerate(counts)
    ]
    frame = one(tmp_path / "two.pts", "".join(scans))
    wanted = [[k, i, 3] for k, count in enumerate(counts) for i in range(count)]
    assert frame.xyz.tolist() == wanted
    assert set(frame.intensity) == {-800}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("# only a comment\n", "lines of numbers"),
        ("Dear diary\n1 2 3\n", "header with x, y and z, got a first line of other"),
        ("1 2\n3 4\n", "3 columns"),
        ("1 2 3\n4 5\n", "line 2"),
        ("1 2 3\n4 5 six\n", "line 2: expected a number, got another word"),
        ("x,y,z\n1,2,3,4\n", "header says"),
        ("3\n1 2 3\n4 5 6\n", "3 points"),
        ("1\n1 2 3\n2\n4 5 6\n", "2 points as line 3 says, got 1"),
        ("1 2 nan\n", "first at point 0"),
        ("x y z label\n1 2 3 0.5\n", "whole labels"),
    ],
)
def test_bad_text_says_what_was_expected(tmp_path, text, message):
    with pytest.raises(BadInputError, match=r"bad\.txt.*expected") as caught:
        one(tmp_path / "bad.txt", text)
    assert message in str(caught.value)


def test_binary_data_is_not_text(tmp_path):
    (tmp_path / "a.csv").write_bytes(bytes(range(256)))
    with pytest.raises(BadInputError, match="expected text"):
        list(read(tmp_path / "a.csv"))


@given(
    hnp.arrays(
        st.sampled_from([np.float32, np.float64]),
        st.tuples(st.integers(1, 20), st.just(3)),
        elements=st.floats(-1e6, 1e6, width=32),
    )
)
def test_csv_reads_back_bit_for_bit(tmp_path_factory, xyz):
    out = io.BytesIO()
    columns = {axis: xyz[:, i] for i, axis in enumerate("xyz")}
    write_csv(out, Table.of(columns | {"label": np.arange(len(xyz), dtype=np.uint16)}))
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    path.write_bytes(out.getvalue())
    (frame,) = read(path)
    kept = np.arange(len(xyz)) if frame.rows is None else frame.rows  # several at 0 0 0 are not
    assert np.array_equal(frame.xyz.astype(xyz.dtype), xyz[kept])
    assert frame.label.tolist() == kept.tolist()


@pytest.mark.parametrize(
    ("separator", "header", "comma"),
    [(",", "", False), (",", "x,y,z,ring,label\n", False), (";", "", True), ("\t", "", False)],
)
def test_long_tables_are_read_as_short_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, separator: str, header: str, comma: bool
) -> None:
    rng = np.random.default_rng(0)
    table = np.column_stack([rng.normal(0, 9, (9000, 3)), rng.integers(0, 9, (9000, 2))])
    body = "\n".join(separator.join(str(float(v)) for v in row) for row in table)
    (tmp_path / "a.csv").write_text(header + (body.replace(".", ",") if comma else body) + "\n")
    (fast,) = read(tmp_path / "a.csv")
    monkeypatch.setattr(text, "LONG", 1 << 60)
    (slow,) = read(tmp_path / "a.csv")
    np.testing.assert_array_equal(fast.xyz, table[:, :3])
    np.testing.assert_array_equal(fast.xyz, slow.xyz)
    for name in ("intensity", "label"):
        one, other = getattr(fast, name), getattr(slow, name)
        assert (one is None) == (other is None)
        if one is not None:
            np.testing.assert_array_equal(one, other)
    assert set(fast.other) == set(slow.other)


def test_what_is_wrong_in_a_long_table_is_said_by_its_line(tmp_path: Path) -> None:
    rows = ["1.5,2.5,3.5,4.5"] * 30_000
    rows[20_000] = "1.5,2.5,oops,4.5"
    (tmp_path / "a.csv").write_text("\n".join(rows))
    with pytest.raises(BadInputError, match="line 20001"):
        list(read(tmp_path / "a.csv"))


def test_columns_without_a_name_are_kept_and_possible_classes_named(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rows = [f"{k / 7:.3f},1,{k % 5},10,{k},30,{k % 3 + 1},{k % 4}" for k in range(40)]
    (tmp_path / "scan.txt").write_text("\n".join(rows))
    (frame,) = read(tmp_path / "scan.txt")
    assert frame.rgb is not None
    assert frame.other["column_7"].tolist() == [k % 3 + 1 for k in range(40)]
    assert frame.other["column_8"].tolist() == [k % 4 for k in range(40)]
    assert "columns x,y,z,red,green,blue,label" in caplog.text


@pytest.mark.parametrize(("name", "labels"), [("a_labeled.txt", True), ("a.txt", False)])
def test_a_fourth_column_is_a_class_where_the_file_is_called_so(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, name: str, labels: bool
) -> None:
    (tmp_path / name).write_text("\n".join(f"{k / 7:.3f} 1 {k / 3:.3f} {k % 3}" for k in range(30)))
    (frame,) = read(tmp_path / name)
    found = frame.label if labels else frame.intensity
    assert found is not None
    assert found.tolist() == [k % 3 for k in range(30)]
    assert (frame.intensity is None) == labels
    assert ("columns x,y,z,label" in caplog.text) != labels


def test_a_column_of_frames_makes_a_sequence(tmp_path: Path) -> None:
    rows = [f"{frame},{k},{frame},0" for k in range(5) for frame in (7, 3)]
    (tmp_path / "a.csv").write_text("frame,x,y,z\n" + "\n".join(rows))
    frames = list(read(tmp_path / "a.csv"))
    assert [frame.xyz[:, 1].tolist() for frame in frames] == [[3] * 5, [7] * 5]
    assert [frame.xyz[:, 0].tolist() for frame in frames] == [list(range(5))] * 2


def test_numbers_beyond_53_bits_stay_exact(tmp_path: Path) -> None:
    wide = [(1 << 60) + k for k in range(4)]
    (tmp_path / "a.csv").write_text("x,y,z,t\n" + "\n".join(f"1,2,3,{t}" for t in wide))
    (frame,) = read(tmp_path / "a.csv")
    assert frame.other["t"].tolist() == wide
