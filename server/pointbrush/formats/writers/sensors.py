"""Frames of several sensors for export: the fields of all points, or the points of one sensor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.boxes.scene import SceneFrame
from pointbrush.formats.writers.labeled import ExportFrame, LabeledFrame
from pointbrush.frame import FramePart, PointFrame, frame_of_part

Matrix = NDArray[np.float64]
SENSOR, TIME = "sensor", "sensor_time"
"""Fields of exported points: the number of each point's sensor, and its time in seconds."""


def with_sensor_fields(frame: LabeledFrame) -> LabeledFrame:
    """Add each point's sensor and, if all are known, its time to the fields of a frame."""
    points = frame.points
    if points.sensor is None:
        return frame
    times = np.full(len(points.sensors), np.nan)
    for part in points.parts:
        times[part.sensor] = np.nan if part.timestamp is None else part.timestamp
    fields: dict[str, NDArray[Any]] = {SENSOR: points.sensor}
    if not np.isnan(times[[part.sensor for part in points.parts]]).any():
        fields[TIME] = times[points.sensor]
    others = {f"source_{n}" if n in fields else n: values for n, values in frame.other.items()}
    return replace(frame, other=others | fields)


def sensor_frames(frames: Iterable[ExportFrame], name: str) -> Iterator[ExportFrame]:
    """Yield the points of the sensor ``name`` of each frame, in its own coordinates."""
    for frame in frames:
        # Frames of several sensors are never in blocks.
        yield _of_sensor(frame, name) if isinstance(frame, LabeledFrame) else frame


def _of_sensor(frame: LabeledFrame, name: str) -> LabeledFrame:
    points = frame.points
    number = [sensor.name for sensor in points.sensors].index(name)
    absent = FramePart(number, np.eye(4))
    part = next((each for each in points.parts if each.sensor == number), absent)
    T, mine = part.T_frame_sensor, np.flatnonzero(points.sensor == number)
    own = frame_of_part(points, part)
    rows, dropped = _own_rows(frame, number, len(mine))
    return replace(
        frame,
        points=replace(
            own,
            rgb=None if own.rgb is None or not own.rgb.any() else own.rgb,
            pose=None if points.pose is None else points.pose @ T,
        ),
        label=frame.label[mine],
        provenance=frame.provenance[mine],
        deleted=frame.deleted[mine],
        tracks=[_moved_track(track, T) for track in frame.tracks],
        up=T[:3, :3].T @ frame.up,
        other=_own_fields(frame.other, mine),
        rows=rows,
        dropped=dropped,
        boxes=None if frame.boxes is None else _moved_boxes(frame.boxes, part),
        sensor=name,
    )


def _own_fields(
    other: Mapping[str, NDArray[Any]], mine: NDArray[np.int64]
) -> dict[str, NDArray[Any]]:
    """Return the source's further fields of points; one that is only 0 is of another sensor."""
    own = {name: values[mine] for name, values in other.items() if name not in (SENSOR, TIME)}
    return {name: values for name, values in own.items() if values.any()}


def _own_rows(frame: LabeledFrame, number: int, count: int) -> tuple[NDArray[np.int64] | None, int]:
    """Return the rows of a sensor's points in its own source, and the number of its other rows.

    The rows of a depth image are its pixels; of other sensors they are the points that were read.
    """
    first, points = 0, frame.points
    for part in points.parts:
        size = part.camera.width * part.camera.height if part.camera is not None else None
        if frame.rows is None or size is None:
            return None, 0
        if part.sensor == number:
            return frame.rows[points.sensor == number] - first, size - count
        first += size
    return None, 0


def _moved_track(track: Mapping[str, Any], T_frame_sensor: Matrix) -> Mapping[str, Any]:
    """Return a track with its pose in the sensor's coordinates."""
    if track.get("pose") is None:
        return track
    pose = np.reshape(track["pose"], (4, 4)).astype(np.float64)
    moved = np.linalg.inv(T_frame_sensor) @ pose @ T_frame_sensor
    return {**track, "pose": moved.ravel().tolist()}


def _moved_boxes(scene: SceneFrame, part: FramePart) -> SceneFrame:
    """Return a frame's boxes in the coordinates of a sensor, at its time."""
    T_frame_sensor, view = part.T_frame_sensor, scene.view
    T_sensor_frame = np.asarray(np.linalg.inv(T_frame_sensor), np.float64)
    return replace(
        scene,
        time=scene.time if part.timestamp is None else part.timestamp,
        boxes=tuple(box.moved(T_sensor_frame) for box in scene.boxes),
        up=T_sensor_frame[:3, :3] @ scene.up,
        pose=None if scene.pose is None else scene.pose @ T_frame_sensor,
        view=None
        if view is None
        else replace(view, T_camera_source=view.T_camera_source @ T_frame_sensor),
        parts=(),
    )


def parts_document(points: PointFrame) -> dict[str, Any]:
    """Describe the sensors of a frame by name: number, type, mount by rows, and time."""
    return {
        points.sensors[part.sensor].name: {
            "number": part.sensor,
            "type": points.sensors[part.sensor].type,
            "T_frame_sensor": part.T_frame_sensor.ravel().tolist(),
            "time": part.timestamp,
        }
        for part in points.parts
    }
