"""Export of a recording's boxes with the names, times and cameras of frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from pointbrush import formats
from pointbrush.formats.boxes.scene import SceneFrame, View, by_frame
from pointbrush.formats.writers.labeled import category_of
from pointbrush.labels import LabelStore
from pointbrush.labels.versions import PastLabels
from pointbrush.sequences import Sequence as Recording

FRONT = ("image_2", "image_02", "CAM_FRONT", "ring_front_center")
"""Names of front cameras, KITTI's first; without one of them the first camera is used."""


def boxed_frames(
    frames: Iterable[formats.ExportFrame], store: LabelStore | PastLabels, recording: Recording
) -> Iterator[formats.ExportFrame]:
    """Yield frames with their boxes, which are read with the first frame."""
    names = frame_stems(recording)
    sequence = recording.manifest.id
    classes = {label.id: category_of(label) for label in store.palette(sequence)}
    boxes = by_frame(store.boxes.listing(sequence).boxes, classes)
    for frame in frames:
        stored = recording[frame.index]
        time = stored.timestamp
        scene = SceneFrame(
            frame.index,
            names[frame.index],
            frame.index / recording.manifest.fps if time is None else time,
            boxes.get(frame.index, ()),
            up=np.asarray(frame.up, np.float64),
            pose=stored.pose,
            view=_view(recording, frame.index),
        )
        yield replace(frame, boxes=scene)


def frame_stems(recording: Recording) -> list[str]:
    """Return the stems of the frames' source files, or frame numbers if stems repeat."""
    manifest = recording.manifest
    stems = [Path(file).stem.removesuffix(".pcd") for file in manifest.files or []]
    whole = len(stems) == manifest.frames and len(set(stems)) == len(stems) and all(stems)
    return stems if whole else [f"{index:06d}" for index in range(manifest.frames)]


def _view(recording: Recording, index: int) -> View | None:
    """Return the front camera among the cameras with known pose and projection."""
    known = {
        each.name: each
        for each in recording.projections(index)
        if each.K is not None and each.T_camera_frame is not None
    }
    name = next((name for name in (*FRONT, *known) if name in known), None)
    if name is None:
        return None
    one = known[name]
    return View(np.array(one.K), np.array(one.T_camera_frame), one.width, one.height)
