"""Source files with hostile columns, written by programs other than pointbrush."""

from __future__ import annotations

import csv
import sqlite3
import struct
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from plyfile import PlyData, PlyElement
from pyarrow import feather

from tests.formats.test_bags import MAGIC, Writer, connection, op, record, stamp, text
from tests.formats.test_e57 import one_scan, packets

Columns = Mapping[str, NDArray[Any]]
COUNT = 24
STEP = np.arange(COUNT)


def coordinates(*, far: bool) -> NDArray[np.float64]:
    """Points (COUNT, 3) on a grid of millimetres; ``far`` from the origin as UTM is."""
    xyz = np.round(np.random.default_rng(5).uniform(-9, 9, (COUNT, 3)), 3)
    return xyz + [447_123.0, 5_411_123.0, 101.0] if far else xyz.astype(np.float32)


def hostile(*, wide: bool = True, words: bool = False) -> dict[str, NDArray[Any]]:
    """Columns that readers and writers have trouble with.

    ``wide``: with integers of 64 bits; ``words``: with a column of words.
    """
    columns: dict[str, NDArray[Any]] = {
        "negative": (-STEP).astype(np.int16),
        "beyond_16_bits": (STEP + 70_000).astype(np.uint32),
        "gps_time": 1.6e9 + STEP * 1e-6,
        "gaps": np.where(STEP % 5 == 1, np.nan, STEP / 7).astype(np.float32),
        "endless": np.where(STEP % 6 == 2, -np.inf, STEP / 3),
        "treeID": (STEP % 4 - 1).astype(np.int32),
        "object_id": (STEP % 3 * 100_000).astype(np.int32),
        "category": (STEP % 9).astype(np.uint8),
        "provenance": (STEP % 7).astype(np.uint8),
        "row": (STEP[::-1]).astype(np.uint16),
        "deleted": (STEP % 2).astype(np.uint8),
        "source_category": (STEP % 5).astype(np.uint8),
        "classification": (STEP % 3).astype(np.uint8),
    }
    if wide:
        columns["beyond_53_bits"] = STEP + (1 << 60)
    if words:
        columns["surveyor"] = np.array([f"Ännä, {k}" for k in STEP])
    return columns


@dataclass(frozen=True)
class Source:
    """A kind of source file: its name, the columns that it holds, and a function that writes it."""

    name: str
    columns: dict[str, NDArray[Any]]
    write: Callable[[Path, NDArray[Any], Columns], Any]
    far: bool = False


def _rows(xyz: NDArray[Any], columns: Columns) -> NDArray[Any]:
    axes = {axis: xyz[:, k] for k, axis in enumerate("xyz")}
    named = axes | dict(columns)
    rows = np.empty(len(xyz), [(name, values.dtype) for name, values in named.items()])
    for name, values in named.items():
        rows[name] = values
    return rows


def _ply(path: Path, xyz: NDArray[Any], columns: Columns, ascii: bool = False) -> None:
    PlyData([PlyElement.describe(_rows(xyz, columns), "vertex")], text=ascii).write(path)


def _ply_text(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    _ply(path, xyz, columns, ascii=True)


def _pcd(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    rows = _rows(xyz, columns)
    kinds = [rows.dtype[name] for name in rows.dtype.names or ()]
    lines = [
        "VERSION 0.7",
        f"FIELDS {' '.join(rows.dtype.names or ())}",
        f"SIZE {' '.join(str(kind.itemsize) for kind in kinds)}",
        f"TYPE {' '.join(kind.kind.upper() for kind in kinds)}",
        f"COUNT {' '.join('1' for _ in kinds)}",
        *(f"WIDTH {len(rows)}", "HEIGHT 1", "VIEWPOINT 0 0 0 1 0 0 0", f"POINTS {len(rows)}"),
        "DATA binary\n",
    ]
    path.write_bytes("\n".join(lines).encode() + rows.tobytes())


def _las(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    """LAS 1.4 of point format 7; ``amplitude`` has a scale, ``deviation`` scale and offset."""
    header = laspy.LasHeader(point_format=7, version="1.4")
    header.scales, header.offsets = np.full(3, 0.001), np.floor(xyz.min(axis=0))
    own = [name for name in columns if name not in header.point_format.dimension_names]
    header.add_extra_dims([_extra(name, columns[name]) for name in own])
    las = laspy.LasData(header)
    las.x, las.y, las.z = xyz.T
    las.red, las.green, las.blue = STEP * 300, 65535 - STEP, STEP * 7
    for name, values in columns.items():
        las[name] = values
    las.write(path)


def _extra(name: str, values: NDArray[Any]) -> laspy.ExtraBytesParams:
    scaled = {
        "amplitude": ("uint16", [0.01], [0.0], None),
        "deviation": ("int32", [0.001], [-500.0], np.array([-9999])),
    }
    if name in scaled:
        kind, scales, offsets, no_data = scaled[name]
        return laspy.ExtraBytesParams(name, kind, "", offsets, scales, no_data)
    return laspy.ExtraBytesParams(name, values.dtype)


def _las_columns() -> dict[str, NDArray[Any]]:
    return hostile() | {
        "amplitude": STEP * 0.01,
        "deviation": np.round(STEP * 0.003 - 499.0, 3),
        "intensity": (STEP * 1000).astype(np.uint16),
        "point_source_id": (STEP + 60_000).astype(np.uint16),
        "classification": (STEP % 3 + 20).astype(np.uint8),
        "scan_angle": (STEP - 90).astype(np.int16),
    }


def _csv(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    named = {axis: xyz[:, k] for k, axis in enumerate("xyz")} | dict(columns)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(named)
        writer.writerows(zip(*(values.tolist() for values in named.values()), strict=True))


def _npy(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    np.save(path, _rows(xyz, columns))


def _npz(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    np.savez(path, xyz=xyz, **columns)


def _feather(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    named = {axis: xyz[:, k] for k, axis in enumerate("xyz")} | dict(columns)
    feather.write_feather(pa.table({name: pa.array(v) for name, v in named.items()}), path)


def _message(rows: NDArray[Any], *, cdr: bool) -> bytes:
    """A PointCloud2 whose fields are those of ``rows``."""
    kinds = dict(zip(("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"), range(1, 9), strict=True))
    message = Writer(cdr=cdr)
    message.header(10.0, "lidar")
    for number in (1, COUNT, len(rows.dtype.names or ())):
        message.number("I", number)
    for name in rows.dtype.names or ():
        kind, offset = (rows.dtype.fields or {})[name][:2]
        message.text(name)
        message.number("I", offset)
        message.number("B", kinds[kind.str[1:]])
        message.number("I", 1)
    message.number("B", 0)
    for number in (rows.itemsize, rows.nbytes, rows.nbytes):
        message.number("I", number)
    return (bytes([0, 1, 0, 0]) if cdr else b"") + message.out + rows.tobytes() + b"\1"


def _bag(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    number = struct.pack("<I", 0)
    content = connection(0, b"/points", b"sensor_msgs/PointCloud2")
    message = _message(_rows(xyz, columns), cdr=False)
    content += record(message, op=b"\x02", conn=number, time=stamp(10.0))
    size = struct.pack("<I", len(content))
    start = record(bytes(200), op=b"\x03", index_pos=bytes(8), conn_count=bytes(4))
    chunk = record(content, op=b"\x05", compression=b"none", size=size)
    path.write_bytes(b"#ROSBAG V2.0\n" + start + chunk)


def _rosbag2(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    with closing(sqlite3.connect(path)) as database:
        database.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INT, timestamp INT, data BLOB);"
            "INSERT INTO topics VALUES (1, '/points', 'sensor_msgs/msg/PointCloud2');"
        )
        row = (1, 10**10, _message(_rows(xyz, columns), cdr=True))
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?,?,?)", row)
        database.commit()


def _mcap(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    schema = struct.pack("<H", 1) + text("sensor_msgs/msg/PointCloud2") + text("ros2msg") + text("")
    channel = struct.pack("<HH", 4, 1) + text("/points") + text("cdr") + struct.pack("<I", 0)
    message = struct.pack("<HIQQ", 4, 0, 10**10, 0) + _message(_rows(xyz, columns), cdr=True)
    start = MAGIC + op(1, text("ros2") + text("test"))
    end = op(0x0F, bytes(4)) + op(2, bytes(20)) + MAGIC
    path.write_bytes(start + op(3, schema) + op(4, channel) + op(5, message) + end)


def _e57(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    """Doubles and single floats of one scan; ASTM E2807."""
    names = ["cartesianX", "cartesianY", "cartesianZ", *columns]
    values = [*xyz.astype("<f8").T, *columns.values()]
    precision = {"f8": "double", "f4": "single"}
    prototype = "".join(
        f'<{name} type="Float" precision="{precision[v.dtype.str[1:]]}"/>'
        for name, v in zip(names, values, strict=True)
    )
    path.write_bytes(one_scan(packets([v.tobytes() for v in values]), prototype, COUNT))


def _xyzrgb(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    table = np.column_stack([xyz, *(columns[c] / 255 for c in ("red", "green", "blue"))])
    path.write_bytes(table.astype("<f4").tobytes())


def _pts(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    rows = np.column_stack([xyz, *columns.values()]).tolist()
    lines = (" ".join(f"{value:.9g}" for value in row) for row in rows)
    path.write_text(f"{COUNT}\n" + "\n".join(lines))


def _nuscenes(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    table = np.column_stack([xyz, columns["intensity"], columns["ring"]])
    path.write_bytes(table.astype("<f4").tobytes())


def _ptx(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    lines = [f"{COUNT}\n1", "0 0 0", "1 0 0", "0 1 0", "0 0 1"]
    lines += ["1 0 0 0", "0 1 0 0", "0 0 1 0", "0 0 0 1"]
    lines += [
        f"{x:.9g} {y:.9g} {z:.9g} {value:.9g}"
        for (x, y, z), value in zip(xyz.tolist(), columns["intensity"].tolist(), strict=True)
    ]
    path.write_text("\n".join(lines) + "\n")


def _kitti(path: Path, xyz: NDArray[Any], columns: Columns) -> None:
    path.write_bytes(np.column_stack([xyz, columns["intensity"]]).astype("<f4").tobytes())


_32 = hostile(wide=False)
_COLORS = {
    "red": (STEP * 9).astype(np.uint8),
    "green": (255 - STEP).astype(np.uint8),
    "blue": (STEP * 2).astype(np.uint8),
}
_INTENSITY = {"intensity": (STEP / 32).astype(np.float32)}
SOURCES = {
    "a.ply": Source("PLY", _32, _ply),
    "b.ply": Source("PLY text", _32, _ply_text, far=True),
    "a.pcd": Source("PCD", hostile(), _pcd),
    "a.las": Source("LAS", _las_columns(), _las, far=True),
    "a.laz": Source("LAZ", _las_columns(), _las, far=True),
    "a.csv": Source("CSV", hostile(words=True), _csv, far=True),
    "a.npy": Source("NPY", hostile(), _npy),
    "a.npz": Source("NPZ", hostile(), _npz),
    "a.feather": Source("feather", hostile(), _feather),
    "a.bag": Source("ROS 1 bag", _32, _bag),
    "a.db3": Source("ROS 2 bag", _32, _rosbag2),
    "a.mcap": Source("MCAP", _32, _mcap),
    "a.e57": Source("E57", _INTENSITY | {"normalX": STEP / 7, "timeStamp": STEP * 1e-6}, _e57),
    "a.xyzrgb": Source("XYZRGB", _COLORS, _xyzrgb),
    "a.pts": Source("PTS", {"intensity": (STEP - 900.0)} | _COLORS, _pts),
    "a.pcd.bin": Source("nuScenes", _INTENSITY | {"ring": STEP.astype(np.float32)}, _nuscenes),
    "a.ptx": Source("PTX", _INTENSITY, _ptx),
    "a.bin": Source("KITTI", _INTENSITY, _kitti),
}
"""Sources by file name."""
