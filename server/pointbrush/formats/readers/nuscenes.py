"""nuScenes' tables beside its sweeps: poses of the scanner, and the cameras' pictures."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.pictures import Camera, PictureSource, of_files
from pointbrush.formats.geometry.interpolation import Pose
from pointbrush.formats.geometry.poses import Poses, of_quaternion
from pointbrush.formats.options import Limits
from pointbrush.formats.tables.parsing import parse_json
from pointbrush.formats.times.matching import FrameName, partners

TOKEN = re.compile(r"([0-9a-f]{32})_(lidarseg\.bin|panoptic\.npz)")
"""Names of label files that are matched to sweeps only by a table."""
LEVELS = 3
"""Folders above label files in which tables are looked for."""
PLACES = ("calibrated_sensor", "ego_pose")
"""Tables of the rows that sample data refer to."""
MOST_APART = 0.1
"""Greatest seconds between a sweep and its picture if no table pairs them."""

Record = dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Tables:
    """The tables in the folder ``name``: sample data, and the rows it refers to by token."""

    name: str
    data: list[Record]
    by_token: dict[str, dict[str, Record]]

    def of_sweeps(self, files: Sequence[Path]) -> list[Record] | None:
        """Return the record of each sweep, or None if a sweep has none."""
        by_name = {Path(str(each.get("filename"))).name: each for each in self.data}
        if any(path.name not in by_name for path in files):
            return None
        return [by_name[path.name] for path in files]


def read_tables(folder: Path) -> Tables | None:
    """Read the tables of the dataset of sweeps in ``folder`` (``samples/LIDAR_TOP``).

    None if there are none.  Raises BadInputError for damaged ones.
    """
    top = folder.parent.parent
    place = next((path.parent for path in sorted(top.glob("v1.0-*/sample_data.json"))), None)
    return None if place is None else tables_in(place)


def tables_in(place: Path) -> Tables:
    """Read the tables in a folder ``v1.0-…``.  Raises BadInputError for damaged or missing ones."""
    by_token = {f"{name}_token": rows_by_token(place / f"{name}.json") for name in PLACES}
    return Tables(place.name, read_table(place / "sample_data.json"), by_token)


def rows_by_token(path: Path) -> dict[str, Record]:
    """Read a table's rows by their tokens.  Raises BadInputError."""
    return {str(each.get("token")): each for each in read_table(path)}


def nuscenes_poses(tables: Tables | None, files: Sequence[Path]) -> Poses | None:
    """Return the poses of sweeps in the first scanner's coordinates, or None without tables.

    Raises BadInputError for damaged tables.
    """
    scans = None if tables is None else tables.of_sweeps(files)
    if tables is None or not scans:
        return None
    chains = [world_from_sensor(scan, tables.by_token) for scan in scans]
    to_first = np.linalg.inv(chains[0])
    return Poses([to_first @ chain for chain in chains], tables.name)


def nuscenes_pictures(
    tables: Tables | None, files: Sequence[Path], folder: Path, limits: Limits
) -> PictureSource | None:
    """Return the pictures of the sweeps' samples, or, without tables or a record of each sweep, the
    pictures nearest in time with unknown cameras.  Raises BadInputError for damaged tables.
    """
    scans = None if tables is None else tables.of_sweeps(files)
    if tables is None or scans is None:
        return _by_time(files, folder, limits)
    top, by_token = folder.parent.parent, tables.by_token
    of_sample: dict[str, list[Record]] = {}
    for each in tables.data:
        if each.get("is_key_frame") and str(each.get("filename")).endswith((".jpg", ".png")):
            of_sample.setdefault(str(each.get("sample_token")), []).append(each)
    rows: list[dict[Camera, Path]] = []
    for scan in scans:
        T_world_scan = world_from_sensor(scan, by_token)
        row = {}
        for each in of_sample.get(str(scan.get("sample_token")), []):
            path = top / str(each["filename"])
            if path.is_file():
                T_camera_frame = np.linalg.inv(world_from_sensor(each, by_token)) @ T_world_scan
                sensor = _of(each, "calibrated_sensor_token", by_token)
                row[_camera(path.parent.name, sensor, T_camera_frame)] = path
        rows.append(dict(sorted(row.items(), key=lambda item: item[0].name)))
    first = next((row for row in rows if row), {})
    return of_files(top, rows, list(first), limits)


def label_times(paths: Sequence[Path]) -> dict[Path, float]:
    """Return the times in seconds of the sweeps of label files named by tokens, from the tables.

    {} if files have other names.  Raises BadInputError for several files without a table.
    """
    tokens = {path: found[1] for path in paths if (found := TOKEN.fullmatch(path.name))}
    if len(tokens) < len(paths) or len(paths) < 2:
        return {}
    places = paths[0].parents[: LEVELS + 1]
    table = next((t for p in places for t in sorted(p.glob("v1.0-*/sample_data.json"))), None)
    if table is None:
        raise BadInputError(
            f"{paths[0].name}: expected nuScenes' tables (v1.0-*/sample_data.json) in a folder "
            "above: file names that are tokens do not identify the sweeps of the labels"
        )
    stamps = {str(each.get("token")): each.get("timestamp") for each in read_table(table)}
    missing = [path.name for path, token in tokens.items() if not _is_time(stamps.get(token))]
    if missing:
        raise BadInputError(f"{table.name}: expected a record of {missing[0]}, got none")
    return {path: float(stamps[token] or 0) / 1e6 for path, token in tokens.items()}


def _is_time(value: object) -> bool:
    return isinstance(value, int | float) and value > 0


def read_table(path: Path) -> list[Record]:
    """Read a table.  Raises BadInputError for another file."""
    try:
        content = parse_json(path.read_bytes())
    except (OSError, ValueError) as error:
        raise BadInputError(f"{path.name}: expected a table of nuScenes, {error}") from None
    if not isinstance(content, list) or not all(isinstance(each, dict) for each in content):
        raise BadInputError(f"{path.name}: expected a table of nuScenes, a list of records")
    return content


def _of(record: Record, key: str, by_token: dict[str, dict[str, Record]]) -> Record:
    found = by_token[key].get(str(record.get(key)))
    if found is None:
        raise BadInputError(f"sample_data.json: {record.get('filename')}: its {key} is not there")
    return found


def world_from_sensor(record: Record, by_token: dict[str, dict[str, Record]]) -> Pose:
    """Compute ``T_world_sensor`` (4, 4) of sample data.  Raises BadInputError."""
    ego = rigid(_of(record, "ego_pose_token", by_token), "ego_pose.json")
    return np.asarray(ego @ calibrated(record, by_token))


def calibrated(record: Record, by_token: dict[str, dict[str, Record]]) -> Pose:
    """Return ``T_ego_sensor`` (4, 4), the mount of the sensor of sample data."""
    return rigid(_of(record, "calibrated_sensor_token", by_token), "calibrated_sensor.json")


def rigid(record: Record, where: str) -> Pose:
    """Read the transform (4, 4) of a record: ``translation`` and ``rotation`` (w, x, y, z).

    Raises BadInputError naming ``where``.
    """
    try:
        w, x, y, z = (float(value) for value in record["rotation"])
        row = np.array([*map(float, record["translation"]), x, y, z, w])
    except (KeyError, TypeError, ValueError):
        row = np.empty(0)
    if row.shape != (7,) or not np.isfinite(row).all():
        raise BadInputError(f"{where}: expected translation (3) and rotation (4) in each record")
    return of_quaternion(where, row)


def _camera(name: str, sensor: Record, T_camera_frame: Pose) -> Camera:
    K = np.array(sensor.get("camera_intrinsic") or [], np.float64)
    if K.shape != (3, 3):
        return Camera(name, None, T_camera_frame)
    return Camera(name, K, T_camera_frame)


def _by_time(files: Sequence[Path], folder: Path, limits: Limits) -> PictureSource | None:
    """Pictures in folders ``CAM_…`` beside the sweeps', by the times in their names."""
    rows: list[dict[Camera, Path]] = [{} for _ in files]
    sweeps = [FrameName(path.name) for path in files]
    cameras = []
    for place in sorted(folder.parent.glob("CAM_*")):
        pictures = [p for p in sorted(place.iterdir()) if p.suffix.lower() in (".jpg", ".png")]
        if not pictures:
            continue
        camera = Camera(place.name)
        cameras.append(camera)
        names = [FrameName(path.name) for path in pictures]
        for row, found in zip(rows, partners(sweeps, names, near=MOST_APART), strict=True):
            if found is not None:
                row[camera] = pictures[found]
    return of_files(folder.parent.parent, rows, cameras, limits)
