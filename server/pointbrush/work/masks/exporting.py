"""Export of labels as masks of the pictures of frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import PurePath

import numpy as np

from pointbrush import formats
from pointbrush.errors import BadInputError
from pointbrush.formats.masks.mask import PictureMask
from pointbrush.masks import draw
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.masks.views import camera_names, depth_images, view_of


def masked_frames(
    frames: Iterable[formats.ExportFrame], recording: Recording, chosen: range, sensor: str | None
) -> Iterator[formats.ExportFrame]:
    """Return the frames with masks of their labels in the pictures of calibrated cameras.

    ``chosen``: numbers of the frames.  ``sensor``: only the points of this one of several sensors
    are drawn, and no depth image of another.  Raises BadInputError if no frame has such a picture.
    """
    if not any(_endings(recording, index, sensor) for index in chosen):
        of_sensor = "" if sensor is None else f" for {sensor}"
        raise BadInputError(
            "format: expected frames with pictures of calibrated cameras or of a depth camera, "
            f"got neither{of_sensor}"
        )
    return (replace(frame, masks=tuple(_masks(frame, recording, sensor))) for frame in frames)


def _endings(recording: Recording, index: int, sensor: str | None) -> dict[str, str]:
    """Return the calibrated cameras of a frame with the endings of their pictures."""
    endings = {
        each.name: PurePath(each.file).suffix
        for each in recording.projections(index)
        if each.K is not None and each.T_camera_frame is not None
    }
    for name, part in depth_images(recording[index]).items():
        if sensor in (None, part.name):
            endings[name] = ".png"
    return {name: endings[name] for name in camera_names(recording, index) if name in endings}


def _masks(
    frame: formats.ExportFrame, recording: Recording, sensor: str | None
) -> Iterator[PictureMask]:
    """Yield the mask of each calibrated camera of a frame."""
    blocks = [(block.label, block.deleted) for block in frame.blocks()]
    label, deleted = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    stored = recording[frame.index]
    order = stored.source_index
    left_out = deleted[order]
    if sensor is not None:
        left_out |= stored.sensor != [each.name for each in stored.sensors].index(sensor)
    for camera, ending in _endings(recording, frame.index, sensor).items():
        view = view_of(recording, frame.index, camera).without(left_out)
        yield PictureMask(camera, draw(view, label[order]), ending)
