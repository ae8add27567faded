"""Reading labels of frames from masks of their pictures."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import chain
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
from pointbrush.work.masks.service import lifted
from pointbrush.work.masks.views import camera_names, size_of

ByCamera = dict[str, MaskFile]
EXACT = LiftOptions(pixel_error=0.0, metre_error=0.0)
"""Options for our exports, in which each point is in the pixel where it was drawn."""


def read_mask_labels(
    channel: Channel, files: LabelFiles, root: Path, recording: Recording, *, by_order: bool
) -> None:
    """Send the labels of each frame from masks, then the names of classes.

    ``root``: folder from which the paths of masks are read as names of cameras and frames.
    Raises BadInputError for masks of another size, without a camera or frame, of a camera without
    calibration.
    """
    names = {path: path.relative_to(root).as_posix() for path in files.paths}
    frames = files.export.frames if files.export else {}
    masks, classes = read_masks(names, files.format, files.names, frames, own=bool(files.own))
    by_frame, unmatched = _frames(masks, files.format, recording, by_order=by_order)
    for name in unmatched:
        channel.item(Unmatched(name))
    keys: set[Key] = set()
    alone, options = len(masks) == 1, EXACT if files.export else LiftOptions()
    for done, (frame, of_frame) in enumerate(sorted(by_frame.items()), 1):
        found = _frame_labels(recording, frame, of_frame, options, alone=alone)
        keys.update(found.keys)
        require_few(keys)
        channel.item(found)
        channel.progress(done / len(by_frame), f"read the masks of {done} frames")
    channel.item(Naming(classes, dict(files.own)))


def _frames(
    masks: Sequence[MaskFile], format: str, recording: Recording, *, by_order: bool
) -> tuple[dict[int, ByCamera], list[str]]:
    """Return the masks by frame and camera, and the names of masks of no frame.

    Tables of pictures may be of more frames than the recording; files may not.
    """
    there = [camera_names(recording, frame) for frame in range(len(recording))]
    cameras = list(dict.fromkeys(chain.from_iterable(there)))
    if not cameras:
        raise BadInputError(
            "masks: expected a recording with pictures of cameras or of a depth camera, got neither"
        )
    of_camera: dict[str, list[MaskFile]] = {}
    for mask in masks:
        of_camera.setdefault(_camera(mask.name, cameras), []).append(mask)
    by_frame: dict[int, ByCamera] = {}
    unmatched: list[str] = []
    known = frame_names(recording.manifest)
    for camera, of_one in of_camera.items():
        for mask, frame in zip(of_one, _matched(of_one, format, known, by_order), strict=True):
            inside = frame is not None and 0 <= frame < len(there) and camera in there[frame]
            if frame is None or not inside or camera in by_frame.get(frame, {}):
                unmatched.append(mask.name)
            else:
                by_frame.setdefault(frame, {})[camera] = mask
    return by_frame, unmatched


def _matched(
    masks: Sequence[MaskFile], format: str, known: Sequence[FrameName], by_order: bool
) -> Sequence[int | None]:
    """Return the frame of each mask of a camera.  Raises the errors of ``match``."""
    if all(mask.frame is not None for mask in masks):
        return [mask.frame for mask in masks]
    files = [mask.name for mask in masks]
    if format == COCO and not by_order:
        found = matched([FrameName(file) for file in files], known)
        if any(frame is not None for frame in found):
            return found
    return match(files, known, by_order=by_order)


def _camera(name: str, cameras: Sequence[str]) -> str:
    """Return the camera whose name is a folder of a file, or a word of its name; the only one.

    Raises BadInputError if there are several cameras and none of them is named.
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
    recording: Recording, frame: int, masks: ByCamera, options: LiftOptions, *, alone: bool
) -> FrameLabels:
    """Return the labels of the points of a frame that are seen in its masks.

    ``alone``: objects of one picture are labels of their own; otherwise they have the label of
    their class, as no number tells them from objects of other pictures.
    """
    keys: dict[Key, int] = {}
    images: dict[str, NDArray[np.uint16]] = {}
    for camera, file in masks.items():
        mask = file.read(size_of(recording, frame, camera))
        values = np.full(1 << 16, VOID, np.uint16)
        values[0] = 0
        for place, key in enumerate(mask.keys, 1):
            values[place] = keys.setdefault(_key(key, alone=alone), len(keys) + 1)
        images[camera] = values[mask.place]
    found = recording[frame].to_source(lifted(recording, frame, images, options))
    rows = np.flatnonzero(found > 0)
    used, which = np.unique(found[rows], return_inverse=True)
    listed, names = list(keys), [mask.name for mask in masks.values()]
    return FrameLabels(
        frame,
        names[0],
        rows,
        which,
        tuple(listed[value - 1] for value in used.tolist()),
        tuple(names[1:]),
        only="not_painted",
        doubtful=int((found < 0).sum()),
    )


def _key(key: MaskKey, *, alone: bool) -> Key:
    number, instance = key
    return number, instance if instance >= 0 else -instance if alone else 0
