"""Reading labels of frames from masks of their pictures."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path, PurePath

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.annotation import LabelFiles
from pointbrush.formats.masks.mask import Key as MaskKey
from pointbrush.formats.masks.mask import MaskFile, folder_of
from pointbrush.formats.masks.registry import COCO, read_masks
from pointbrush.formats.times.matching import FrameName, match, matched
from pointbrush.jobs.worker import Channel
from pointbrush.masks import LiftOptions
from pointbrush.sequences import Sequence as Recording
from pointbrush.values.masks import VOID
from pointbrush.work.imports.choosing import require_few
from pointbrush.work.imports.frame_labels import FrameLabels, Unmatched, frame_names
from pointbrush.work.imports.naming import Key, Naming
from pointbrush.work.masks.service import lift_masks
from pointbrush.work.masks.views import camera_names, size_of

ByCamera = dict[str, MaskFile]
EXPORT_OPTIONS = LiftOptions(pixel_error=0.0, metre_error=0.0)
"""Options for masks that pointbrush exported: each point is in the pixel where it was drawn."""


def read_mask_labels(
    channel: Channel, files: LabelFiles, root: Path, recording: Recording, *, by_order: bool
) -> None:
    """Send the labels of each frame from masks, then the names of classes.

    ``root``: folder that the names of masks are relative to; they contain cameras and frames.
    Raises BadInputError for masks of another size, without a camera or frame, or of a camera
    without calibration.
    """
    names = {path: path.relative_to(root).as_posix() for path in files.paths}
    frames = files.export.frames if files.export else {}
    masks, classes = read_masks(names, files.format, files.names, frames, own=bool(files.own))
    by_frame, unmatched = _frames(masks, files.format, recording, by_order=by_order)
    for name in unmatched:
        channel.item(Unmatched(name))
    keys: set[Key] = set()
    options = EXPORT_OPTIONS if files.export else LiftOptions()
    for done, (frame, of_frame) in enumerate(sorted(by_frame.items()), 1):
        found = _frame_labels(recording, frame, of_frame, options, single=len(masks) == 1)
        keys.update(found.keys)
        require_few(keys)
        channel.item(found)
        channel.progress(done / len(by_frame), f"read the masks of {done} frames")
    channel.item(Naming(classes, dict(files.own)))


def _frames(
    masks: Sequence[MaskFile], format: str, recording: Recording, *, by_order: bool
) -> tuple[dict[int, ByCamera], list[str]]:
    """Return the masks by frame and camera, and the names of masks without a frame."""
    pictures = [
        (frame, name) for frame in range(len(recording)) for name in camera_names(recording, frame)
    ]
    cameras = list(dict.fromkeys(name for _, name in pictures))
    if not cameras:
        raise BadInputError(
            "masks: expected a recording with pictures of cameras or of a depth camera, got neither"
        )
    of_camera: dict[str, list[MaskFile]] = {}
    for mask in masks:
        of_camera.setdefault(_camera_of(mask.name, cameras), []).append(mask)
    by_frame: dict[int, ByCamera] = {}
    unmatched: list[str] = []
    known, without_mask = frame_names(recording.manifest), set(pictures)
    for camera, of_one in of_camera.items():
        for mask, frame in zip(of_one, _matched(of_one, format, known, by_order), strict=True):
            if frame is None or (frame, camera) not in without_mask:
                unmatched.append(mask.name)
            else:
                without_mask.remove((frame, camera))
                by_frame.setdefault(frame, {})[camera] = mask
    return by_frame, unmatched


def _matched(
    masks: Sequence[MaskFile], format: str, known: Sequence[FrameName], by_order: bool
) -> Sequence[int | None]:
    """Return the frame of each mask of a camera, None for masks without one.

    A COCO file may list pictures of more frames than the recording has; files of masks may not.
    Raises the errors of ``match``.
    """
    if all(mask.frame is not None for mask in masks):
        return [mask.frame for mask in masks]
    files = [mask.name for mask in masks]
    if format == COCO and not by_order:
        found = matched([FrameName(file) for file in files], known)
        if any(frame is not None for frame in found):
            return found
    return match(files, known, by_order=by_order)


def _camera_of(name: str, cameras: Sequence[str]) -> str:
    """Return the camera that a mask's folder or a word of its path names; else the only camera.

    Raises BadInputError if there are several cameras and the path names none of them.
    """
    parts = [*reversed(PurePath(name).parent.parts), PurePath(name).stem]
    folders = {folder_of(camera).lower(): camera for camera in cameras}
    for part in parts:
        if (found := folders.get(folder_of(part).lower())) is not None:
            return found
    longest = sorted(folders, key=len, reverse=True)
    for part in reversed(parts):
        for folder in longest:
            if re.search(rf"(?<![^\W_]){re.escape(folder)}(?![^\W_])", part.lower()):
                return folders[folder]
    if len(cameras) == 1:
        return cameras[0]
    raise BadInputError(
        f"{name}: expected a folder with the name of a camera ({', '.join(cameras)}), got none"
    )


def _frame_labels(
    recording: Recording, frame: int, masks: ByCamera, options: LiftOptions, *, single: bool
) -> FrameLabels:
    """Return the labels of a frame's points behind its masks.

    ``single``: the import has one mask.  Only then objects of one picture are separate labels:
    their numbers do not identify them in other pictures.
    """
    keys: dict[Key, int] = {}
    images: dict[str, NDArray[np.uint16]] = {}
    for camera, file in masks.items():
        mask = file.read(size_of(recording, frame, camera))
        values = np.full(1 << 16, VOID, np.uint16)
        values[0] = 0
        for place, key in enumerate(mask.keys, 1):
            values[place] = keys.setdefault(_key(key, single=single), len(keys) + 1)
        images[camera] = values[mask.place]
    number = recording[frame].to_source(lift_masks(recording, frame, images, options))
    rows = np.flatnonzero(number > 0)
    used, key_index = np.unique(number[rows], return_inverse=True)
    all_keys, names = list(keys), [mask.name for mask in masks.values()]
    return FrameLabels(
        frame,
        names[0],
        rows,
        key_index,
        tuple(all_keys[value - 1] for value in used.tolist()),
        tuple(names[1:]),
        only="not_painted",
        doubtful=int((number < 0).sum()),
    )


def _key(key: MaskKey, *, single: bool) -> Key:
    """Return the class and the instance of a label, 0 for none."""
    number, instance = key
    return number, instance if instance >= 0 else -instance if single else 0
