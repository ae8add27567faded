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
    frames: Iterable[formats.ExportFrame], recording: Recording, chosen: range
) -> Iterator[formats.ExportFrame]:
    """Return the frames with masks of their labels in the pictures of calibrated cameras.

    ``chosen``: numbers of the frames.  Raises BadInputError if none of them has such a camera.
    """
    if not any(_endings(recording, index) for index in chosen):
        raise BadInputError(
            "format: expected frames with pictures of calibrated cameras or of a depth camera, "
            "got neither"
        )
    return (replace(frame, masks=tuple(_masks(frame, recording))) for frame in frames)


def _endings(recording: Recording, index: int) -> dict[str, str]:
    """Return the calibrated cameras of a frame with the endings of their pictures."""
    endings = {
        each.name: PurePath(each.file).suffix
        for each in recording.projections(index)
        if each.K is not None and each.T_camera_frame is not None
    }
    endings |= dict.fromkeys(depth_images(recording[index]), ".png")
    return {name: endings[name] for name in camera_names(recording, index) if name in endings}


def _masks(frame: formats.ExportFrame, recording: Recording) -> Iterator[PictureMask]:
    """Yield the mask of each calibrated camera of a frame."""
    blocks = [(block.label, block.deleted) for block in frame.blocks()]
    label, deleted = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    order = recording[frame.index].source_index
    for camera, ending in _endings(recording, frame.index).items():
        view = view_of(recording, frame.index, camera).without(deleted[order])
        yield PictureMask(camera, draw(view, label[order]), ending)
