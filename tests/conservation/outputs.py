"""Exports read by programs other than pointbrush: columns by name, in the file's order."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import laspy
import numpy as np
from numpy.typing import NDArray
from plyfile import PlyData

Columns = dict[str, NDArray[Any]]
COLORS = ("red", "green", "blue")


def _ply(folder: Path) -> Columns:
    vertex = PlyData.read(folder / "000000.ply")["vertex"]
    return {name: np.asarray(vertex[name]) for name in vertex.data.dtype.names}


def _cut(folder: Path) -> Columns:
    """Points of the only label, which has all."""
    (path,) = folder.glob("*/000000.ply")
    vertex = PlyData.read(path)["vertex"]
    return {name: np.asarray(vertex[name]) for name in vertex.data.dtype.names}


def _pcd(folder: Path) -> Columns:
    data = (folder / "000000.pcd").read_bytes()
    at = data.index(b"DATA binary\n") + len(b"DATA binary\n")
    lines = [line.split() for line in data[:at].decode().splitlines()]
    header = {words[0]: words[1:] for words in lines if words and words[0] != "#"}
    kinds = [
        f"<{kind.lower()}{size}" for kind, size in zip(header["TYPE"], header["SIZE"], strict=True)
    ]
    assert set(header["COUNT"]) == {"1"}
    rows = np.frombuffer(data, np.dtype(list(zip(header["FIELDS"], kinds, strict=True))), -1, at)
    found = {name: rows[name] for name in header["FIELDS"]}
    packed = found.pop("rgba", None)
    shifts = {"red": 16, "green": 8, "blue": 0}
    return found | ({} if packed is None else {c: packed >> n & 255 for c, n in shifts.items()})


def _npz(folder: Path) -> Columns:
    with np.load(folder / "000000.npz") as arrays:
        found = dict(arrays)
    xyz, rgb = found.pop("xyz"), found.pop("rgb", None)
    colors = {} if rgb is None else {c: rgb[:, k] for k, c in enumerate(COLORS)}
    return found | colors | {axis: xyz[:, k] for k, axis in enumerate("xyz")}


def _las(folder: Path) -> Columns:
    (path,) = folder.glob("000000.la[sz]")
    las = laspy.read(path)
    names = [name for name in las.point_format.dimension_names if name not in ("X", "Y", "Z")]
    found = {name: np.asarray(las[name]) for name in (*"xyz", *names)}
    eight = {color: found[color] // 257 for color in COLORS if color in found}
    return found | {c: v for c, v in eight.items() if np.array_equal(v * 257, found[c])}


def _csv(folder: Path) -> Columns:
    with (folder / "000000.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return {name: _typed([row[k] for row in rows]) for k, name in enumerate(header)}


def _typed(words: list[str]) -> NDArray[Any]:
    """Whole numbers, numbers ("" is none) or words."""
    for parse in (int, lambda word: float(word or "nan")):
        try:
            return np.array([parse(word) for word in words])
        except ValueError:
            continue
    return np.array(words)


def _semantickitti(folder: Path) -> Columns:
    root = folder / "sequences" / "00"
    table = np.fromfile(root / "velodyne" / "000000.bin", "<f4").reshape(-1, 4).astype(float)
    if (root / "poses.txt").is_file():
        table[:, :3] += np.loadtxt(root / "poses.txt").reshape(3, 4)[:, 3]
    return dict(zip(("x", "y", "z", "intensity"), table.T, strict=True))


def _placed(folder: Path, points: NDArray[Any]) -> Columns:
    import json

    about = json.loads((folder / "export.json").read_text())
    T = np.array(about.get("T_export_source", np.eye(4).tolist()))
    back = np.linalg.inv(T)
    xyz = points[:, :3].astype(float) @ back[:3, :3].T + back[:3, 3]
    return {axis: xyz[:, k] for k, axis in enumerate("xyz")}


def _pointcept(folder: Path) -> Columns:
    (scene,) = folder.glob("*/*_000000")
    found = _placed(folder, np.load(scene / "coord.npy"))
    if (scene / "strength.npy").is_file():
        found["intensity"] = np.load(scene / "strength.npy")[:, 0]
    return found


def _openpcdet(folder: Path) -> Columns:
    (path,) = folder.glob("points/*.npy")
    table = np.load(path)
    return _placed(folder, table) | {"intensity": table[:, 3]}


READERS: dict[str, Callable[[Path], Columns]] = {
    "ply": _ply,
    "npz": _npz,
    "pcd": _pcd,
    "las": _las,
    "laz": _las,
    "csv": _csv,
    "cut": _cut,
    "semantickitti": _semantickitti,
    "pointcept": _pointcept,
    "openpcdet": _openpcdet,
}
"""Readers of the exports that hold points, by format."""
