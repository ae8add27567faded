"""Masks in PNG images: class indices with 8 or 16 bits, colours of classes, and binary masks.

16 bits without a class for each value are a class times 1000 plus an object, as Cityscapes writes
``*_instanceIds.png``.  ``SegmentationObject`` of VOC and CVAT numbers the objects of the classes in
``SegmentationClass``.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.images import opened
from pointbrush.formats.masks.classes import MaskClasses, read_classes
from pointbrush.formats.masks.mask import (
    MOST_PIXELS,
    NONE,
    UNKNOWN,
    Key,
    Mask,
    MaskFile,
    Size,
    distinct,
)
from pointbrush.formats.masks.png import DEEP, PLAIN, VOID_8_BIT, read_png
from pointbrush.formats.options import read_bytes
from pointbrush.formats.tables.datasets import ClassName
from pointbrush.formats.times.matching import listed
from pointbrush.values.masks import VOID

log = logging.getLogger(__name__)
PER_CLASS = 1000
"""Factor of the class in a number of class and object."""
GRAY = 0x010101
"""Colour of which the shades of grey are multiples."""
MOST_COLORS = 256
"""Most colours of a mask in colours of classes; a photograph has more."""
VOC_BORDER = 0xE0E0C0
"""Colour of the borders of objects in VOC's masks."""
CLASS, OBJECT = "SegmentationClass", "SegmentationObject"
ILLUSTRATION = re.compile(r"SegmentationClassVisualization|_(gtFine_)?color$|_vis$|_overlay$")
"""Folders and names of images that illustrate masks."""
CITYSCAPES = ("instanceIds", "labelIds", "labelTrainIds")
"""Ends of the names of Cityscapes' masks of one picture, the most informative one first."""


def is_mask_image(path: Path) -> bool:
    """Return whether a PNG image is a mask rather than a photograph."""
    if path.suffix.lower() != ".png":
        return False
    try:
        with opened(path.name, path, "a mask") as image:
            if image.mode not in ("RGB", "RGBA") or image.width * image.height > MOST_PIXELS:
                return True
            return image.convert("RGB").getcolors(MOST_COLORS) is not None
    except BadInputError:
        return True  # reading it explains the damage


def find_masks(paths: Sequence[Path]) -> list[Path]:
    """Return the most informative mask of each picture, without images that illustrate masks."""
    masks = [path for path in paths if not ILLUSTRATION.search(f"{path.parent.name}/{path.stem}")]
    best: dict[Path, Path] = {}
    for path in sorted(masks, key=_rank):
        best.setdefault(_without_kind(path), path)
    return sorted(best.values())


def _without_kind(path: Path) -> Path:
    """Return the path of a mask without its kind; all masks of a picture share it."""
    folder = path.parent.parent / CLASS if path.parent.name == OBJECT else path.parent
    return folder / re.sub(f"_({'|'.join(CITYSCAPES)})$", "", path.stem)


def _rank(path: Path) -> tuple[bool, int, Path]:
    """Return a sort key that puts the most informative mask of a picture first."""
    kinds = [*(path.stem.endswith(f"_{end}") for end in CITYSCAPES), True]
    return path.parent.name == OBJECT, kinds.index(True), path


@dataclass(slots=True, eq=False)
class ImageMasks:
    """Reader of the images of one import.

    ``names``: classes by number; reading adds colours that no file names.  ``own``: numbers are
    ids of labels in a palette of pointbrush.
    """

    classes: MaskClasses
    names: dict[int, ClassName]
    own: bool = False
    _color_numbers: dict[int, int] = field(default_factory=dict)
    """Class numbers of the colours that no file names."""

    @classmethod
    def of(cls, first: Path, names: Mapping[int, ClassName], *, own: bool) -> ImageMasks:
        """Return a reader with the classes of the mask ``first``; ``names``: from the caller."""
        classes = MaskClasses() if own else read_classes(first)
        return cls(classes, {**classes.names, **names}, own)

    def masks(self, paths: Mapping[Path, str], frames: Mapping[Path, int]) -> list[MaskFile]:
        """Return the masks of images.

        ``paths``: names of the images; ``frames``: frames by path in an export of pointbrush.
        Raises BadInputError for objects without classes.
        """
        alone = [path for path in paths if path.parent.name == OBJECT]
        if alone and not self.own:
            file = alone[0].name
            raise BadInputError(
                f"{OBJECT}/{file}: expected the classes of the objects in {CLASS}/{file}, got no "
                "such file"
            )
        return [
            MaskFile(name, partial(self.read, path), frames.get(path))
            for path, name in paths.items()
        ]

    def read(self, path: Path, size: Size) -> Mask:
        """Return the mask of a picture of a size.  Raises BadInputError."""
        name = f"{path.parent.name}/{path.name}"
        image = read_png(name, read_bytes(path), size)
        values, place = distinct(_pixels(image, colored=self.classes.by_color))
        keys = self._keys(image.mode, values.tolist(), name)
        if (objects := _objects_of(path)) is not None:
            where = f"{OBJECT}/{objects.name}"
            numbers, number_place = distinct(_pixels(read_png(where, read_bytes(objects), size)))
            count, first = len(numbers), int(numbers[0] > 0)
            pairs, place = distinct(place.astype(np.int64) * count + number_place)
            keys = [_with_object(keys[k // count], k % count + first) for k in pairs.tolist()]
        return Mask.of_keys(name, keys, place)

    def _keys(self, mode: str, values: list[int], name: str) -> list[Key]:
        """Return the keys of the values of an image."""
        if mode in DEEP:
            return self._of_deep(values, name)
        if mode not in PLAIN or (mode == "P" and self.classes.by_color):
            if self._has_colors(values):
                return self._of_colors(values, name)
            values = [value & 255 for value in values]
        if mode != "P" and {*values} <= {0, 255}:
            return [(1, 0) if value else self._of_index(0) for value in values]
        return [self._of_index(value) for value in values]

    def _has_colors(self, values: list[int]) -> bool:
        """Return whether colours stand for classes; otherwise they are indices in grey."""
        gray = all(value == (value & 255) * GRAY for value in values)
        colors = self.classes.colors
        return not gray or self.classes.by_color or any(v in colors for v in values if v)

    def _of_index(self, value: int, void: int = VOID_8_BIT) -> Key:
        """Return the key of an index: ``void`` is UNKNOWN and 0 NONE, unless they have a name."""
        if value in self.names:
            return value, 0
        return NONE if value == 0 else UNKNOWN if value == void else (value, 0)

    def _of_deep(self, values: list[int], name: str) -> list[Key]:
        keys = [self._of_index(value, void=VOID) for value in values]
        numbers = {key[0] for key in keys} - {NONE[0], UNKNOWN[0]}
        if self.own or numbers <= self.names.keys():
            return keys
        classes = {each // PER_CLASS if each >= PER_CLASS else each for each in numbers}
        if unnamed := [str(each) for each in sorted(classes - self.names.keys())]:
            stated = self.classes.file or "a classes.txt beside the masks (or --map)"
            raise BadInputError(
                f"{name}: expected the classes of {stated} in 8 bits, or in 16 bits as class times "
                f"{PER_CLASS} plus object, got 16 bits with classes {listed(unnamed)}, "
                "which have no name there"
            )
        return [divmod(k, PER_CLASS) if k >= PER_CLASS else (k, i) for k, i in keys]

    def _of_colors(self, colors: list[int], name: str) -> list[Key]:
        if len(colors) > MOST_COLORS:
            raise BadInputError(
                f"{name}: expected a mask with at most {MOST_COLORS} colours, got {len(colors):,} "
                "as in a photograph"
            )
        return [self._of_color(each, name) for each in colors]

    def _of_color(self, color: int, name: str) -> Key:
        colors = self.classes.colors
        if color in colors:
            number = colors[color]
            return NONE if number is None else (number, 0)
        if color in (0, VOC_BORDER):
            return UNKNOWN if color else NONE
        if colors:
            log.warning(
                "%s: the colour #%06x has no class in %s and is left out",
                name.split("/")[0], color, self.classes.file,
            )  # fmt: skip
            return UNKNOWN
        number = self._color_numbers.setdefault(color, len(self._color_numbers) + 1)
        name = f"#{color:06x}"
        self.names.setdefault(number, ClassName(name, name))
        return number, 0


def _with_object(key: Key, number: int) -> Key:
    """Return the key of a class with the number of an object of one picture alone, 0 for none."""
    return key if key in (NONE, UNKNOWN) else (key[0], -number)


def _objects_of(path: Path) -> Path | None:
    """Return the file with the objects of the picture of a file of classes, or None."""
    beside = path.parent.parent / OBJECT / path.name
    return beside if path.parent.name == CLASS and beside.is_file() else None


def _pixels(image: Image.Image, *, colored: bool = False) -> NDArray[np.integer]:
    """Return the numbers (height, width) of pixels: indices, or colours 0xrrggbb.

    Transparent colours are black.  ``colored``: indices of a palette are colours too.
    """
    if image.mode in PLAIN and not (colored and image.mode == "P"):
        return np.asarray(image.convert("L") if image.mode == "1" else image)
    red, green, blue, alpha = np.moveaxis(np.asarray(image.convert("RGBA")), 2, 0).astype(np.int32)
    return np.where(alpha > 0, red << 16 | green << 8 | blue, 0)
