"""All sensors of a drive of nuScenes or Argoverse 2, by the tables of the data set."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.folder import ARGOVERSE_SCANS, list_folder
from pointbrush.formats.geometry.poses import of_quaternion
from pointbrush.formats.inside import require_inside
from pointbrush.formats.listing import FrameFile
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.readers.feather import MOUNTS, PLACE, read_table
from pointbrush.formats.readers.nuscenes import (
    Record,
    calibrated,
    read_tables,
    world_from_sensor,
)
from pointbrush.formats.sensors.extrinsics import Extrinsics
from pointbrush.formats.sensors.streams import Stream
from pointbrush.frame import PointFrame
from pointbrush.geometry.mounts import Matrix
from pointbrush.values.kinds import SensorType

KINDS: dict[str, SensorType] = {"LIDAR": "spinning", "RADAR": "radar"}
"""Types of nuScenes' sensors with points, by the beginnings of their names."""
LASER = "laser_number"
UP, DOWN = "up_lidar", "down_lidar"
"""The two scanners of Argoverse 2; the points of both are in one file, in the vehicle's axes."""
LASERS = 32
"""Lasers of each scanner of Argoverse 2."""


def nuscenes_streams(folder: Path, options: ReadOptions) -> list[Stream]:
    """Return the lidars and radars of nuScenes, the lidar on top first; [] for another folder.

    ``folder``: ``samples``, the folder above it, or the folder of a sensor.  Points are joined in
    the coordinates of the first lidar, at its position at the time of its sweep.
    """
    beside = folder.parent if folder.name[:5] in KINDS else folder
    place = beside / "samples" if (beside / "samples").is_dir() else beside
    inside = [p for p in place.iterdir() if p.is_dir() and p.name[:5] in KINDS]
    inside.sort(key=lambda each: (each.name[:5], each.name != "LIDAR_TOP", each.name))
    tables = read_tables(inside[0]) if len(inside) > 1 else None
    if tables is None:
        return []
    if options.limits.roots:
        require_inside(inside, options.limits.roots)
    streams: list[Stream] = []
    T_first_ego: Matrix = np.eye(4)
    for each in inside:
        listing = list_folder(each, None, options if each is inside[0] else _without_poses(options))
        rows = tables.of_sweeps([Path(file.name) for file in listing.frames])
        if rows is None:
            raise BadInputError(f"{tables.name}: expected records of all files in {each.name}")
        world = [world_from_sensor(row, tables.by_token) for row in rows]
        T_ego_sensor = calibrated(rows[0], tables.by_token)
        if not streams:
            T_first_ego = np.asarray(np.linalg.inv(T_ego_sensor))
        known = Extrinsics(T_first_ego @ T_ego_sensor, KINDS[each.name[:5]])
        timed = replace(listing, times=_times(rows) or listing.times)
        streams.append(Stream(each.name, timed, known, world))
    return streams


def _times(rows: Sequence[Record]) -> list[float] | None:
    stamps = [row.get("timestamp") for row in rows]
    known = [stamp / 1e6 for stamp in stamps if isinstance(stamp, int | float)]
    return known if len(known) == len(rows) else None


def _without_poses(options: ReadOptions) -> ReadOptions:
    return replace(options, chosen=replace(options.chosen, poses="none"))


def argoverse_streams(log: Path, options: ReadOptions) -> list[Stream]:
    """Return the two lidars of an Argoverse 2 log; [] for another folder.

    Raises BadInputError for a table without their mounts.
    """
    path = log / MOUNTS
    if not path.is_file() or not (log / ARGOVERSE_SCANS).is_dir():
        return []
    table = read_table(path, options.limits, ("sensor_name",))
    if not {"sensor_name", *PLACE} <= table.keys():
        raise BadInputError(f"{path.name}: expected columns sensor_name, {', '.join(PLACE)}")
    rows = np.stack([np.asarray(table[name], np.float64) for name in PLACE], axis=1)
    mounts = dict(zip(table["sensor_name"].tolist(), rows, strict=True))
    if not {UP, DOWN} <= mounts.keys():
        raise BadInputError(f"{path.name}: expected {UP} and {DOWN}, got {', '.join(mounts)}")
    places = {name: of_quaternion(f"{path.name} {name}", mounts[name]) for name in (UP, DOWN)}
    listing = list_folder(log / ARGOVERSE_SCANS, None, options)
    low = _low_lasers(next(listing.frames[0].read(options)), places)
    return [
        Stream(
            name,
            replace(
                listing,
                frames=[
                    replace(file, read=partial(_of_scanner, file, name == low, place))
                    for file in listing.frames
                ],
            ),
            Extrinsics(place, "spinning"),
        )
        for name, place in places.items()
    ]


def _of_scanner(
    file: FrameFile, low: bool, T_ego_sensor: Matrix, options: ReadOptions
) -> Iterator[PointFrame]:
    """Yield the points of a scanner in its own coordinates.

    They are float64: the way back to the vehicle gives the coordinates of the file exactly.
    """
    for frame in file.read(options):
        rows = np.flatnonzero((_lasers(frame) < LASERS) == low)
        yield PointFrame(
            _in_sensor(frame, rows, T_ego_sensor),
            intensity=None if frame.intensity is None else frame.intensity[rows],
            pose=None if frame.pose is None else frame.pose @ T_ego_sensor,
            timestamp=frame.timestamp,
            other={name: values[rows] for name, values in frame.other.items()},
        )


def _lasers(frame: PointFrame) -> NDArray[np.int64]:
    if LASER not in frame.other:
        raise BadInputError(f"sensors/lidar: expected a column {LASER}, got none")
    return frame.other[LASER].astype(np.int64)


def _in_sensor(
    frame: PointFrame, rows: NDArray[np.int64], T_ego_sensor: Matrix
) -> NDArray[np.float64]:
    T = np.linalg.inv(T_ego_sensor)
    return np.asarray(frame.xyz[rows].astype(np.float64) @ T[:3, :3].T + T[:3, 3], np.float64)


def _low_lasers(frame: PointFrame, places: dict[str, Matrix]) -> str:
    """Return the scanner of lasers 0 to 31, which logs do not state.

    Seen from its own scanner a laser has one elevation: the sum of the spreads of all decides.
    """
    laser = _lasers(frame)

    def spread(name: str, first: int) -> float:
        total = 0.0
        for number in range(first, first + LASERS):
            x, y, z = _in_sensor(frame, np.flatnonzero(laser == number), places[name]).T
            total += float(np.std(np.arctan2(z, np.hypot(x, y)))) if len(z) else 0.0
        return total

    as_named = spread(UP, 0) + spread(DOWN, LASERS)
    return UP if as_named <= spread(DOWN, 0) + spread(UP, LASERS) else DOWN
