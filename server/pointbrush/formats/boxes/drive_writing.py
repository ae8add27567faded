"""Boxes as tables of data sets of drives: nuScenes, Argoverse 2, Waymo."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.attributes import dotted
from pointbrush.formats.boxes.conventions import numbers_by
from pointbrush.formats.boxes.drives import (
    SCANNER,
    SIZES,
    WAYMO_BOX,
    WAYMO_KEYS,
    WAYMO_TYPE,
    WAYMO_TYPES,
)
from pointbrush.formats.boxes.figures import FrameBox
from pointbrush.formats.boxes.scene import File, Scene, SceneFrame, ScenePart
from pointbrush.formats.readers.feather import MOUNTS, PLACE, POSES, STAMP
from pointbrush.geometry.quaternions import quaternion_of
from pointbrush.geometry.rotations import upright_axes

Floats = NDArray[np.float64]
Record = dict[str, Any]
VERSION = "v1.0-pointbrush"
"""Folder of nuScenes' tables."""
LEVELS = ("v0-40", "v40-60", "v60-80", "v80-100")
"""nuScenes' levels of visibility, 1 to 4."""
MAP = "maps/none.png"
"""Picture of a map that the devkit needs: one pixel of an unknown map."""
MICROSECONDS, NANOSECONDS = 1e6, 1e9
NEAR = 1e-6
"""Greatest difference in seconds of a file's name from the time of its frame."""


def ego_from_source(frame: SceneFrame) -> Floats:
    """Make ``T_ego_source`` (4, 4): forward, left and up about the source's origin."""
    T = np.eye(4)
    T[:3, :3] = upright_axes(frame.up)
    return T


def _ego_poses(frames: Iterable[SceneFrame]) -> Iterator[tuple[SceneFrame, Floats]]:
    """Yield each frame with ``T_world_ego`` (4, 4), the world level; the identity without poses."""
    level: Floats | None = None
    for frame in frames:
        pose = np.eye(4) if frame.pose is None else frame.pose
        if level is None:
            level = np.eye(4)
            level[:3, :3] = upright_axes(pose[:3, :3] @ frame.up)
        yield frame, np.asarray(level @ pose @ np.linalg.inv(ego_from_source(frame)))


def _rigid(T: Floats) -> Record:
    """Describe a transform as nuScenes does: the quaternion is w x y z."""
    turn = quaternion_of(T[:3, :3])[[3, 0, 1, 2]]
    return {"translation": T[:3, 3].tolist(), "rotation": turn.tolist()}


def write_nuscenes(frames: Iterable[SceneFrame], scene: Scene) -> Iterator[File]:
    """Write the tables that nuScenes' devkit loads; each frame is a sample with its key frame.

    The points of ``samples/LIDAR_TOP/NAME.pcd.bin`` are named, not written.
    """
    tables = _Tables(scene)
    for frame, T_world_ego in _ego_poses(frames):
        tables.add(frame, T_world_ego)
    for name, rows in tables.finished().items():
        yield f"{VERSION}/{name}.json", json.dumps(rows, indent=1, ensure_ascii=False).encode()
    from PIL import Image

    picture = io.BytesIO()
    Image.new("L", (1, 1)).save(picture, "PNG")
    yield MAP, picture.getvalue()


class _Tables:
    """Rows of nuScenes' tables, filled frame by frame."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self.rows: dict[str, list[Record]] = {
            name: [] for name in ("sample", "sample_data", "sample_annotation", "ego_pose")
        }
        self._sensors: dict[str, Record] = {}
        self._mounts: dict[str, tuple[Record, Floats]] = {}
        """The row of each sensor's mount at its first frame, and the mount, ``T_ego_sensor``."""
        self._attributes: dict[str, int] = {}
        self._instances: dict[int, Record] = {}

    def add(self, frame: SceneFrame, T_world_ego: Floats) -> None:
        """Add a frame as a sample, with a row of data a sensor, and the rows of its boxes."""
        token, number = self._scene.token, frame.index
        T_ego_source = ego_from_source(frame)
        sample = {"token": token("sample", number), "scene_token": token("scene", 0)}
        self.rows["sample"].append(sample | {"timestamp": ticks(frame.time, MICROSECONDS)})
        for part in frame.parts or (ScenePart(SCANNER, "spinning", np.eye(4), frame.time),):
            self._measure(frame, part, T_world_ego, T_ego_source @ part.T_source_sensor)
        for box, points, of_radar in frame.radar_counted():
            self._annotate(frame, box.moved(T_world_ego @ T_ego_source), points, of_radar)

    def _measure(
        self, frame: SceneFrame, part: ScenePart, T_world_ego: Floats, T_ego_sensor: Floats
    ) -> None:
        """Add a sensor's row of data, and the vehicle's pose by which its fixed mount is right."""
        token, radar = self._scene.token, part.type == "radar"
        if part.name not in self._mounts:
            known = len(self._mounts)
            sensor = {"token": token("sensor", known), "channel": part.name}
            self._sensors[part.name] = sensor | {"modality": "radar" if radar else "lidar"}
            row: Record = {"token": token("calibrated", known), "sensor_token": sensor["token"]}
            row |= {**_rigid(T_ego_sensor), "camera_intrinsic": []}
            self._mounts[part.name] = row, T_ego_sensor
        calibrated, T_ego_mount = self._mounts[part.name]
        moved = T_world_ego @ T_ego_sensor @ np.linalg.inv(T_ego_mount)
        own, stamp = f" {part.name}" * bool(frame.parts), ticks(part.time, MICROSECONDS)
        pose = {"token": token(f"pose{own}", frame.index), **_rigid(moved)}
        data = {
            "token": token(f"data{own}", frame.index),
            "sample_token": token("sample", frame.index),
            "ego_pose_token": pose["token"],
            "calibrated_sensor_token": calibrated["token"],
            "filename": f"samples/{part.name}/{frame.name}{'.pcd' if radar else '.pcd.bin'}",
            "fileformat": "pcd",
            "width": 0,
            "height": 0,
            "is_key_frame": True,
        }
        self.rows["ego_pose"].append(pose | {"timestamp": stamp})
        self.rows["sample_data"].append(data | {"timestamp": stamp})

    def _annotate(self, frame: SceneFrame, box: FrameBox, points: int, of_radar: int) -> None:
        token, place = self._scene.token, numbers_by("nuscenes", box)
        attributes = dict(box.attributes)
        seen = attributes.pop("visibility", None)
        row = {
            "token": token(f"annotation {frame.index}", box.label),
            "sample_token": token("sample", frame.index),
            "instance_token": token("object", box.label),
            "attribute_tokens": [self._attribute(*each) for each in attributes.items()],
            "visibility_token": str(LEVELS.index(str(seen)) + 1) if seen in LEVELS else "",
            **dict(zip(("translation", "size", "rotation"), place, strict=True)),
            "num_lidar_pts": points,
            "num_radar_pts": of_radar,
        }
        self.rows["sample_annotation"].append(row)
        category = token(f"category {box.name}", 0)
        first = {"token": token("object", box.label), "category_token": category}
        self._instances.setdefault(box.label, first)

    def _attribute(self, name: str, value: Any) -> str:
        number = self._attributes.setdefault(dotted(name, value), len(self._attributes))
        return self._scene.token("attribute", number)

    def finished(self) -> dict[str, list[Record]]:
        """Chain the rows in time, and return them with the tables that they refer to."""
        token, rows = self._scene.token, self.rows
        _chain(rows["sample"], lambda _: "")
        _chain(rows["sample_data"], lambda row: str(row["calibrated_sensor_token"]))
        ends = _chain(rows["sample_annotation"], lambda row: str(row["instance_token"]))
        log = {"token": token("log", 0), "logfile": "", "vehicle": "", "date_captured": ""}
        samples = [row["token"] for row in rows["sample"]]
        scene = {
            "token": token("scene", 0),
            "log_token": log["token"],
            "nbr_samples": len(samples),
            "first_sample_token": samples[0] if samples else "",
            "last_sample_token": samples[-1] if samples else "",
            "name": self._scene.recording,
            "description": "",
        }
        maps = {
            "token": token("map", 0),
            "log_tokens": [log["token"]],
            "category": "semantic_prior",
        }
        return rows | {
            "scene": [scene],
            "log": [log | {"location": ""}],
            "map": [maps | {"filename": MAP}],
            "sensor": list(self._sensors.values()),
            "calibrated_sensor": [row for row, _ in self._mounts.values()],
            "category": [
                {"token": token(f"category {name}", 0), "name": name, "description": "", "index": k}
                for k, name in enumerate(self._scene.classes, start=1)
            ],
            "attribute": [
                {"token": token("attribute", number), "name": name, "description": ""}
                for name, number in self._attributes.items()
            ],
            "visibility": [
                {"token": str(number), "level": level, "description": ""}
                for number, level in enumerate(LEVELS, start=1)
            ],
            "instance": [
                row
                | dict(zip(("nbr_annotations", *FIRST_LAST), ends[str(row["token"])], strict=True))
                for row in self._instances.values()
            ],
        }


FIRST_LAST = ("first_annotation_token", "last_annotation_token")


def _chain(rows: Iterable[Record], key: Any) -> dict[str, tuple[int, str, str]]:
    """Link each row to the previous and next row of its key; return count and ends of each key."""
    last: dict[str, Record] = {}
    ends: dict[str, tuple[int, str, str]] = {}
    for row in rows:
        before = last.get(key(row))
        row["prev"], row["next"] = before["token"] if before else "", ""
        if before:
            before["next"] = row["token"]
        count, first, _ = ends.get(key(row), (0, row["token"], ""))
        ends[key(row)] = count + 1, first, row["token"]
        last[key(row)] = row
    return ends


def ticks(seconds: float, per_second: float) -> int:
    """Count the units of time in seconds; raises BadInputError beyond 64 bits."""
    found = round(seconds * per_second)
    if abs(found) >= 1 << 63:
        raise BadInputError(
            f"time of a frame: expected one that fits the format, got {seconds:g} s; is the rate "
            "of the recording right?"
        )
    return found


def stamp_of(frame: SceneFrame) -> int:
    """Return a frame's time in nanoseconds, exactly if its file is named by it."""
    named = int(frame.name) if frame.name.isascii() and frame.name.isdigit() else -1
    return named if abs(named / NANOSECONDS - frame.time) < NEAR else ticks(frame.time, NANOSECONDS)


def write_argoverse(frames: Iterable[SceneFrame], scene: Scene) -> Iterator[File]:
    """Write ``annotations.feather`` and the vehicle's poses; boxes are in its coordinates.

    The mounts of several sensors are those at the first frame of each.
    """
    columns: dict[str, list[Any]] = {name: [] for name in (*ARGOVERSE, "num_interior_pts")}
    mounts: dict[str, Floats] = {}
    poses: dict[str, list[Any]] = {name: [] for name in (STAMP, *PLACE)}
    for frame, T_world_ego in _ego_poses(frames):
        stamp = stamp_of(frame)
        place = (*T_world_ego[:3, 3], *quaternion_of(T_world_ego[:3, :3]))
        for name, value in zip(poses, (stamp, *place), strict=True):
            poses[name].append(value)
        for part in frame.parts:
            mounts.setdefault(part.name, ego_from_source(frame) @ part.T_source_sensor)
        for box, points in frame.counted():
            numbers = numbers_by("argoverse", box.moved(ego_from_source(frame)))
            center, size, (w, x, y, z) = numbers
            key = scene.token("object", box.label)
            uuid = "-".join((key[:8], key[8:12], key[12:16], key[16:20], key[20:]))
            row = (stamp, uuid, box.name, *center, x, y, z, w, *size, points)
            for name, value in zip(columns, row, strict=True):
                columns[name].append(value)
    yield "annotations.feather", _feather(columns)
    yield POSES, _feather(poses)
    if mounts:
        rows = [(*T[:3, 3], *quaternion_of(T[:3, :3])) for T in mounts.values()]
        places = dict(zip(PLACE, map(list, zip(*rows, strict=True)), strict=True))
        yield MOUNTS, _feather({"sensor_name": list(mounts), **places})


ARGOVERSE = (STAMP, "track_uuid", "category", *PLACE, *SIZES)


def _feather(columns: Mapping[str, list[Any]]) -> bytes:
    import pyarrow as pa
    from pyarrow import feather

    types = {STAMP: pa.int64(), "num_interior_pts": pa.int64()}
    words = {"track_uuid", "category", "sensor_name"}
    table = pa.table(
        {
            name: pa.array(values, types.get(name, pa.string() if name in words else pa.float64()))
            for name, values in columns.items()
        }
    )
    sink = io.BytesIO()
    feather.write_feather(table, sink, compression="uncompressed")
    return sink.getvalue()


def write_waymo(frames: Iterable[SceneFrame], scene: Scene) -> Iterator[File]:
    """Write ``lidar_box/RECORDING.parquet``, a component of the Waymo Open Dataset, version 2.

    Its classes are vehicle, pedestrian, sign and cyclist; other classes become unknown.
    """
    import pyarrow as pa
    from pyarrow import parquet

    numbers = {name: number for number, name in WAYMO_TYPES.items()}
    columns: dict[str, list[Any]] = {name: [] for name in WAYMO_COLUMNS}
    for frame in frames:
        stamp = ticks(frame.time, MICROSECONDS)
        for box, points in frame.counted():
            place, size, turn = numbers_by("waymo", box.moved(ego_from_source(frame)))
            kind = numbers.get(box.name.lower(), 0)
            row = (scene.recording, stamp, box.key, *place, *size, *turn, kind, points, points)
            for name, value in zip(columns, row, strict=True):
                columns[name].append(value)
    types = (pa.string(), pa.int64(), pa.string(), *[pa.float64()] * len(WAYMO_BOX))
    schema = pa.schema(zip(WAYMO_COLUMNS, (*types, pa.int8(), pa.int64(), pa.int64()), strict=True))
    sink = io.BytesIO()
    parquet.write_table(pa.table(columns, schema=schema), sink)
    yield f"lidar_box/{scene.recording}.parquet", sink.getvalue()


WAYMO_COLUMNS = (
    *("key.segment_context_name", *WAYMO_KEYS, *WAYMO_BOX, WAYMO_TYPE),
    *(WAYMO_TYPE.replace("type", f"num_{kind}points_in_box") for kind in ("lidar_", "top_lidar_")),
)
