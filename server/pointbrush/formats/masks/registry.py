"""Formats of masks: recognition of their files, and their readers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pointbrush.formats.masks.coco import is_coco, read_coco
from pointbrush.formats.masks.images import ImageMasks, find_masks, is_mask_image
from pointbrush.formats.masks.mask import MaskFile
from pointbrush.formats.masks.yolo import is_yolo, read_yolo
from pointbrush.formats.tables.datasets import ClassName

PNG, COCO, YOLO = "masks-png", "masks-coco", "masks-yolo"
MASK_FORMATS = (PNG, COCO, YOLO)


def mask_files(paths: Sequence[Path], format: str, *, sure: bool) -> list[Path]:
    """Return the masks of a format among files, one for each picture.

    ``sure``: only files whose content or neighbours identify the format.  The first image of a
    folder decides whether its images are masks.
    """
    if format == COCO:
        return [path for path in paths if is_coco(path)]
    if format == YOLO:
        return [path for path in paths if is_yolo(path, sure=sure)]
    images = [path for path in paths if path.suffix.lower() == ".png"]
    first_images = {path.parent: path for path in reversed(images)}
    folders = {folder for folder, first in first_images.items() if not sure or is_mask_image(first)}
    return find_masks([path for path in images if path.parent in folders])


def read_masks(
    paths: Mapping[Path, str],
    format: str,
    names: Mapping[int, ClassName],
    frames: Mapping[Path, int],
    *,
    own: bool,
) -> tuple[list[MaskFile], dict[int, ClassName]]:
    """Return the masks in files, and the classes by number.

    Reading a mask may add colours to the classes.  ``paths``: names of files, which contain camera
    and frame; ``names``: names of classes from the caller; ``frames``: frames by path in an export
    of pointbrush; ``own``: numbers are ids of labels in a palette of pointbrush.
    Raises BadInputError.
    """
    if format == YOLO:
        return read_yolo(paths, names)
    if format == PNG:
        images = ImageMasks.of(next(iter(paths)), names, own=own)
        return images.masks(paths, frames), images.names
    masks: list[MaskFile] = []
    classes: dict[int, ClassName] = {}
    for path, name in paths.items():
        of_file, categories = read_coco(path, name, own=own)
        masks += of_file
        classes |= categories
    return masks, {**classes, **names}
