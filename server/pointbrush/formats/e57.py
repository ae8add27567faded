"""E57: all scans of a file as one frame, each moved by its pose."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.columns import colors_of, frame_from_columns
from pointbrush.formats.e57_file import E57File, decode, number, open_e57, prototype, streams
from pointbrush.formats.options import Extras, ReadOptions, read_bytes, require_count
from pointbrush.frame import PointFrame

Array = NDArray[Any]
Columns = dict[str, Array]
COLORS = ("red", "green", "blue")
# What a scan without colour gets beside scans with colour.
GREY = 128


def read_e57(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """One file as one frame: its scans one after the other, in the file's coordinates.

    Points that the scanner marked invalid are missing measurements: left out and counted.
    Raises BadInputError for damaged pages, XML or packets, TooLargeError beyond the limits.
    """
    file = open_e57(path.name, read_bytes(path))
    scans = file.root.findall("data3D/vectorChild")
    counts = [_count(file, scan) for scan in scans]
    require_count(path.name, sum(counts), options.limits)
    parts = [_columns(file, scan, count) for scan, count in zip(scans, counts, strict=True)]
    columns = _joined(parts)
    position = _pose(file, scans[0])[:3, 3] if len(scans) == 1 else None
    extras = Extras(viewpoint=position if position is not None and position.any() else None)
    yield frame_from_columns(path.name, columns, options, missing=True, extras=extras)


def _count(file: E57File, scan: Element) -> int:
    points = scan.find("points")
    text = "" if points is None else points.get("recordCount", "")
    if not (text.isascii() and text.isdigit()) or int(text[:18]) > 8 * len(file.logical):
        raise BadInputError(f"{file.name}: expected a recordCount that fits the file, got another")
    return int(text)


def _columns(file: E57File, scan: Element, count: int) -> Columns:
    points = scan.find("points")
    assert points is not None  # noqa: S101
    fields = prototype(file.name, points)
    packed = streams(file, points, count) if count else [bytearray() for _ in fields]
    values = {
        field.name: decode(file.name, field, stream, count)
        for field, stream in zip(fields, packed, strict=True)
        if field.kind != "text"
    }
    columns = dict(zip("xyz", _placed(file, scan, values), strict=True))
    if {"colorRed", "colorGreen", "colorBlue"} <= set(values):
        limits = {field.name: (field.low, field.high) for field in fields}
        columns |= _colors(file, scan, values, limits)
    if "intensity" in values:
        columns["intensity"] = values["intensity"].astype(np.float32)
    return columns


def _placed(file: E57File, scan: Element, values: Columns) -> Array:
    """(3, N) coordinates in the file's frame; NaN where invalid."""
    if {"cartesianX", "cartesianY", "cartesianZ"} <= set(values):
        xyz = np.stack([values[f"cartesian{axis}"] for axis in "XYZ"])
        state = values.get("cartesianInvalidState")
    elif {"sphericalRange", "sphericalAzimuth", "sphericalElevation"} <= set(values):
        radius, azimuth, elevation = (
            values[f"spherical{part}"].astype(np.float64)
            for part in ("Range", "Azimuth", "Elevation")
        )
        flat = radius * np.cos(elevation)
        xyz = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), radius * np.sin(elevation)])
        state = values.get("sphericalInvalidState")
    else:
        raise BadInputError(
            f"{file.name}: expected cartesian or spherical coordinates, got {', '.join(values)}"
        )
    pose = _pose(file, scan)
    if not np.array_equal(pose, np.eye(4)):
        xyz = pose[:3, :3] @ xyz + pose[:3, 3:]
    if state is not None:
        xyz[:, state != 0] = np.nan
    return xyz


def _pose(file: E57File, scan: Element) -> NDArray[np.float64]:
    """``T_file_scan``."""
    name, pose = file.name, np.eye(4)
    find = scan.find
    quaternion = [number(name, find(f"pose/rotation/{part}"), 0.0) for part in "xyzw"]
    if any(quaternion) and np.isfinite(quaternion).all():
        from scipy.spatial.transform import Rotation

        pose[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    pose[:3, 3] = [number(name, find(f"pose/translation/{part}"), 0.0) for part in "xyz"]
    if not np.isfinite(pose).all():
        raise BadInputError(f"{name}: expected a finite pose, got {pose[:3, 3].tolist()}")
    return pose


def _colors(
    file: E57File, scan: Element, values: Columns, limits: dict[str, tuple[float, float]]
) -> Columns:
    """Colours as uint8, by the limits that the scan states, else by the fields' ranges."""
    colors: Columns = {}
    for color in COLORS:
        name = f"color{color.capitalize()}"
        low, high = limits[name]
        low = number(file.name, scan.find(f"colorLimits/{name}Minimum"), low)
        high = number(file.name, scan.find(f"colorLimits/{name}Maximum"), high)
        channel = values[name]
        if np.isfinite([low, high]).all() and high > low and not (low == 0 and high == 255):
            channel = np.clip((channel - low) / (high - low), 0, 1) * 255
        colors[color] = channel
    stacked = np.stack([np.rint(colors[color]) for color in COLORS], axis=1)
    eight = colors_of(
        file.name, stacked.astype(np.int64) if np.isfinite(stacked).all() else stacked
    )
    return {color: eight[:, i] for i, color in enumerate(COLORS)}


def _joined(parts: list[Columns]) -> Columns:
    """Scans end to end; what only some of them have is filled in for the others."""
    names = list(dict.fromkeys(name for part in parts for name in part)) or list("xyz")
    joined: Columns = {}
    for name in names:
        filler = GREY if name in COLORS else 0
        pieces = [
            part[name]
            if name in part
            else np.full(len(part["x"]), filler, np.uint8 if name in COLORS else np.float32)
            for part in parts
        ]
        joined[name] = np.concatenate(pieces) if pieces else np.empty(0, np.float32)
    return joined
