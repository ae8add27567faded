"""LAS and LAZ: exact coordinates, colours, chunks, and headers that lie."""

from __future__ import annotations

import struct

import laspy
import numpy as np
import pytest

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats import Limits, open_source, read
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.readers import las
from pointbrush.formats.readers.las import read_chunks
from pointbrush.formats.readers.las_header import read_header
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.formats.tables.table import Table
from pointbrush.formats.writers.las import write_las

CLASSES = np.arange(1 << 16, dtype=np.uint16) % 3


def make(path, *, version="1.2", form=3, count=1000, color=65535, scale=0.001):
    rng = np.random.default_rng(5)
    header = laspy.LasHeader(version=version, point_format=form)
    header.scales, header.offsets = [scale] * 3, [600000, 5_000_000, 100]
    las = laspy.LasData(header)
    counts = rng.integers(-100_000, 100_000, (count, 3))
    las.X, las.Y, las.Z = counts.T
    las.intensity = rng.integers(0, 65536, count)
    if form in (2, 3, 5, 7, 8, 10):
        las.red = las.green = las.blue = np.linspace(0, color, count).astype(np.uint16)
    las.write(path)
    return counts * scale + header.offsets, las


def one(path, **kwargs):
    (frame,) = read(path, **kwargs)
    return frame


@pytest.mark.parametrize("ending", ["las", "laz"])
@pytest.mark.parametrize(
    ("version", "form"),
    [("1.2", 0), ("1.2", 1), ("1.2", 2), ("1.2", 3), ("1.4", 6), ("1.4", 7), ("1.4", 8)],
)
def test_reads_what_laspy_wrote(tmp_path, ending, version, form):
    xyz, las = make(tmp_path / f"a.{ending}", version=version, form=form)
    frame = one(tmp_path / f"a.{ending}")
    assert frame.xyz.dtype == np.float64
    assert np.array_equal(frame.xyz, xyz)
    assert np.array_equal(frame.intensity, las.intensity)
    if frame.rgb is not None:
        assert np.array_equal(frame.rgb[:, 0], las.red >> 8)


def test_colours_left_at_8_bits_are_not_darkened(tmp_path):
    _, las = make(tmp_path / "a.las", color=255)
    assert np.array_equal(one(tmp_path / "a.las").rgb[:, 1], las.green)


@pytest.mark.parametrize("ending", ["las", "laz"])
def test_chunks_are_the_whole_file_in_order(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    xyz, _ = make(path, count=1050)
    chunks = list(read_chunks(path, 100))
    assert [len(chunk) for chunk in chunks] == [100] * 10 + [50]
    assert np.array_equal(np.concatenate([chunk.xyz for chunk in chunks]), xyz)
    header = read_header(path, Limits())
    assert header.count == 1050
    assert np.allclose(header.lo, xyz.min(axis=0))
    assert np.allclose(header.hi, xyz.max(axis=0))


@pytest.mark.parametrize("compress", [False, True])
@pytest.mark.parametrize(
    "xyz",
    [
        np.array([[637012.24, 849028.31, 431.66], [636896.33, 849087.7, 446.39]]),
        np.random.default_rng(2).normal(size=(100, 3)).astype(np.float32),
        np.zeros((1, 3)),
        np.empty((0, 3)),
    ],
)
def test_written_files_read_back_with_labels(tmp_path, xyz, compress):
    columns = {axis: xyz[:, i] for i, axis in enumerate("xyz")}
    label = np.arange(len(xyz), dtype=np.uint16)
    columns |= {c: np.full(len(xyz), 77, np.uint8) for c in ("red", "green", "blue")}
    columns |= {"label": label, "category": label % 3, "instance": label}
    path = tmp_path / ("a.laz" if compress else "a.las")
    with path.open("wb") as file:
        write_las(file, Table.of(columns), CLASSES, compress=compress)
    frame = one(path)
    assert np.allclose(frame.xyz, xyz, rtol=0, atol=1e-8)
    assert np.array_equal(frame.label, label)
    assert (frame.rgb == 77).all()
    independent = laspy.read(path)
    assert np.array_equal(independent["label"], label)
    assert np.array_equal(independent.classification, label % 3)


def patch(data: bytes, at: int, form: str, *values) -> bytes:
    changed = bytearray(data)
    struct.pack_into(form, changed, at, *values)
    return bytes(changed)


BAD = {
    "empty": lambda d: d[:0],
    "magic": lambda d: b"LASX" + d[4:],
    "header only": lambda d: d[:100],
    "cut off": lambda d: d[:-1],
    "version": lambda d: patch(d, 24, "<BB", 7, 7),
    "point format": lambda d: patch(d, 104, "<B", 55),
    "record": lambda d: patch(d, 105, "<H", 3),
    "offset": lambda d: patch(d, 96, "<I", 0xFFFFFFFF),
    "offset in header": lambda d: patch(d, 96, "<I", 20),
    "count": lambda d: patch(d, 107, "<I", 400_000_000),
    "scale": lambda d: patch(d, 131, "<d", float("nan")),
    "zero scale": lambda d: patch(d, 139, "<d", 0.0),
    "compressed without a record": lambda d: patch(d, 104, "<B", 3 | 0x80),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_headers_say_what_was_expected(tmp_path, case):
    make(tmp_path / "a.las", count=10)
    (tmp_path / "bad.las").write_bytes(BAD[case]((tmp_path / "a.las").read_bytes()))
    with pytest.raises(BadInputError, match=r"bad\.las: expected .* got"):
        one(tmp_path / "bad.las")


def test_a_garbage_number_of_records_is_not_followed(tmp_path):
    xyz, _ = make(tmp_path / "a.las", count=10)
    (tmp_path / "b.las").write_bytes(patch((tmp_path / "a.las").read_bytes(), 100, "<I", 2**31))
    assert np.array_equal(one(tmp_path / "b.las").xyz, xyz)


def test_damaged_compression_raises_and_ends(tmp_path):
    make(tmp_path / "a.laz", count=5000)
    data = (tmp_path / "a.laz").read_bytes()
    offset = struct.unpack_from("<I", data, 96)[0]
    (tmp_path / "cut.laz").write_bytes(data[: offset + 500])
    (tmp_path / "table.laz").write_bytes(patch(data, offset, "<q", 2**62))
    (tmp_path / "record.laz").write_bytes(patch(data, 105, "<H", 40))
    for name in ("cut", "table", "record"):
        with pytest.raises(BadInputError, match="compressed points"):
            one(tmp_path / f"{name}.laz")


def test_the_decoder_is_held_to_its_memory(tmp_path):
    make(tmp_path / "a.laz", count=10)
    options = ReadOptions(limits=Limits(native_memory=1 << 20))
    with pytest.raises(BadInputError, match="compressed points"):
        list(read_chunks(tmp_path / "a.laz", 100, options))


def test_a_decoder_that_stalls_is_ended(tmp_path, monkeypatch):
    make(tmp_path / "a.laz", count=10)
    (tmp_path / "child.py").write_text("import time; time.sleep(60)")
    monkeypatch.setattr(las, "CHILD", tmp_path / "child.py")
    options = ReadOptions(limits=Limits(native_stall_seconds=0.2))
    with pytest.raises(BadInputError, match="stalled"):
        list(read_chunks(tmp_path / "a.laz", 100, options))


def test_a_decoder_that_dies_is_told_of(tmp_path, monkeypatch):
    make(tmp_path / "a.laz", count=10)
    (tmp_path / "child.py").write_text("import os; os.kill(os.getpid(), 9)")
    monkeypatch.setattr(las, "CHILD", tmp_path / "child.py")
    with pytest.raises(BadInputError, match=r"got 0: the decoder ended \(-9\)"):
        one(tmp_path / "a.laz")


def test_more_points_than_the_limit_is_too_large(tmp_path):
    make(tmp_path / "a.laz", count=10)
    options = ReadOptions(limits=Limits(max_points=9))
    with pytest.raises(TooLargeError, match="at most 9 points"):
        list(read_chunks(tmp_path / "a.laz", 100, options))


@pytest.mark.parametrize("columns", [(), ("treeID=label",)])
@pytest.mark.parametrize(
    ("kind", "no_data"), [("f8", np.finfo(np.float64).max), ("i4", -(2**31)), ("u2", 9999)]
)
def test_values_that_a_file_declares_to_be_none_cost_their_points(
    tmp_path, caplog, kind, no_data, columns
):
    # As lidR writes its trees: NA is declared in the description of the extra bytes.
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.add_extra_dim(laspy.ExtraBytesParams("treeID", kind, no_data=np.array([no_data], kind)))
    las = laspy.LasData(header)
    las.x = las.y = las.z = np.arange(4.0)
    las.treeID = np.array([7, no_data, 12, no_data], kind)
    las.write(tmp_path / "a.laz")
    with open_source([tmp_path / "a.laz"], chosen=Corrections(columns=columns)) as source:
        (frame,) = source.frames
    made = frame.label if columns else frame.instance
    assert made.tolist() == [7, 0, 12, 0]
    assert "numbers" not in caplog.text


def test_a_renamed_field_keeps_its_values_beside_a_scaled_one(tmp_path):
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.add_extra_dim(laspy.ExtraBytesParams("amplitude", "u2", scales=[0.01], offsets=[0.0]))
    header.add_extra_dim(laspy.ExtraBytesParams("ring", "u2"))
    las = laspy.LasData(header)
    las.x = las.y = las.z = np.arange(4.0)
    las.amplitude, las.ring, las.user_data = np.arange(4) / 100, np.arange(4) + 60, np.arange(4) + 9
    las.write(tmp_path / "a.las")
    chosen = Corrections(columns=("ring=user_data",))
    with open_source([tmp_path / "a.las"], chosen=chosen) as source:
        (frame,) = source.frames
    assert frame.other["user_data"].tolist() == [60, 61, 62, 63]
    assert frame.other["amplitude"].tolist() == [0, 1, 2, 3]
