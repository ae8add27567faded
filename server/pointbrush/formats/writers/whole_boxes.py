"""Whole boxes of labels in formats for detection, see ``formats.boxes.writing``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.boxes.drive_writing import ego_from_source
from pointbrush.formats.boxes.scene import Scene, SceneFrame, ScenePart
from pointbrush.formats.boxes.writing import BoxWriting
from pointbrush.formats.writers.about import PLACEMENT, TIMES
from pointbrush.formats.writers.labeled import ExportFrame, LabeledFrame, Palette, category_of
from pointbrush.formats.writers.output import Output
from pointbrush.formats.writers.points import write_palette
from pointbrush.frame import PointFrame


def write_whole_boxes(
    kind: BoxWriting, frames: Iterable[ExportFrame], palette: Palette, output: Output
) -> dict[str, Any]:
    """Write the boxes of frames in a format; return the times and placement of the frames."""
    manifest: dict[str, Any] = {"extent": "whole", TIMES: {}}
    waiting = iter(frames)
    first = next(waiting, None)
    if first is None:
        return manifest

    def counted() -> Iterator[SceneFrame]:
        for frame in chain([first], waiting):
            with_points = _counted(frame)
            manifest[TIMES][frame.index] = with_points.time
            if kind.level:
                manifest.setdefault(PLACEMENT, ego_from_source(with_points).tolist())
            yield with_points

    for name, content in kind.write(counted(), scene_of(palette, first.recording)):
        with output.file(name) as file:
            file.write(content)
    write_palette(palette, output)
    return manifest


def scene_of(palette: Palette, recording: str) -> Scene:
    """Describe the classes of a palette, each in the colour of its first label."""
    colors: dict[str, str] = {}
    for entry in palette.entries:
        colors.setdefault(category_of(entry), entry.color)
    return Scene(recording or "recording", colors)


def boxes_of(frame: ExportFrame) -> SceneFrame:
    """Return the boxes of a frame, or none if it has no boxes."""
    return frame.boxes or SceneFrame(frame.index, frame.stem, float(frame.index), (), up=frame.up)


def _counted(frame: ExportFrame) -> SceneFrame:
    """Count the points of a frame that are in each of its boxes, deleted ones left out."""
    found = boxes_of(frame)
    total, of_radar = np.zeros((2, len(found.boxes)), np.int64)
    for block in frame.blocks() if found.boxes else ():
        xyz = block.points.xyz[block.keep].astype(np.float64)
        radar = _is_radar(block)[block.keep]
        for k, box in enumerate(found.boxes):
            inside = box.inside(xyz)
            total[k] += np.count_nonzero(inside)
            of_radar[k] += np.count_nonzero(inside & radar)
    parts = _parts(frame.points, found.time) if isinstance(frame, LabeledFrame) else ()
    return replace(
        found,
        points=tuple(total.tolist()),
        radar_points=tuple(of_radar.tolist()),
        parts=parts,
    )


def _is_radar(block: LabeledFrame) -> NDArray[np.bool_]:
    """Mark the points (N,) of radars."""
    sensor = block.points.sensor
    if sensor is None:
        return np.zeros(block.count, np.bool_)
    return np.array([each.type == "radar" for each in block.points.sensors])[sensor]


def _parts(points: PointFrame, time: float) -> tuple[ScenePart, ...]:
    return tuple(
        ScenePart(
            points.sensors[part.sensor].name,
            points.sensors[part.sensor].type,
            part.T_frame_sensor,
            time if part.timestamp is None else part.timestamp,
        )
        for part in points.parts
    )
