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
SHOWN = re.compile(r"SegmentationClassVisualization|_(gtFine_)?color$|_vis$|_overlay$")
"""Folders and names of pictures that only show masks."""
WHOLE = ("instanceIds", "labelIds", "labelTrainIds")
"""Ends of the names of Cityscapes' masks of one picture, the first with all that others have."""


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
    """Return the masks among images, one for each picture, without images that only show masks."""
    shown = [path for path in paths if not SHOWN.search(f"{path.parent.name}/{path.stem}")]
    stems = {path: _stem(path) for path in shown}
    best: dict[Path, Path] = {}
    for path in sorted(shown, key=_order):
        best.setdefault(stems[path], path)
    return sorted(best.values())


def _stem(path: Path) -> Path:
    """Return the path of a mask without its kind, which all masks of a picture share."""
    folder = path.parent.parent / CLASS if path.parent.name == OBJECT else path.parent
    return folder / re.sub(f"_({'|'.join(WHOLE)})$", "", path.stem)


def _order(path: Path) -> tuple[int, Path]:
    """Return the place of a mask among those of its picture."""
    ends = next((k for k, end in enumerate(WHOLE) if path.stem.endswith(f"_{end}")), len(WHOLE))
    return (len(WHOLE) + 1 if path.parent.name == OBJECT else ends), path


@dataclass(slots=True, eq=False)
class ImageMasks:
    """Reader of the images of one import.

    ``names``: classes by number, which it adds to as it meets colours without a class.
    ``own``: numbers are ids of labels in a palette of pointbrush.
    """

    classes: MaskClasses
    names: dict[int, ClassName]
    own: bool = False
    _met: dict[int, int] = field(default_factory=dict)
    """Numbers of colours without a file that names them."""

    @classmethod
    def of(cls, first: Path, given: Mapping[int, ClassName], *, own: bool) -> ImageMasks:
        """Return the reader of masks beside ``first``; ``given``: names from the caller."""
        classes = MaskClasses() if own else read_classes(first)
        return cls(classes, {**classes.names, **given}, own)

    def masks(self, paths: Mapping[Path, str], frames: Mapping[Path, int]) -> list[MaskFile]:
        """Return the masks of images by path and name.

        ``frames``: frames by path in an export of pointbrush.
        """
        alone = [path for path in paths if path.parent.name == OBJECT]
        if alone and not self.own:
            raise BadInputError(
                f"{alone[0].parent.name}/{alone[0].name}: expected the classes of the objects in "
                f"{CLASS}/{alone[0].name}, got no such file"
            )
        return [
            MaskFile(name, partial(self.read, path), frames.get(path))
            for path, name in paths.items()
        ]

    def read(self, path: Path, size: Size) -> Mask:
        """Read a mask.  Raises BadInputError."""
        name = f"{path.parent.name}/{path.name}"
        image = read_png(name, read_bytes(path), size)
        found, place = distinct(_pixels(image, colored=self.classes.by_color))
        keys = self._keys(image.mode, found.tolist(), name)
        if (objects := _objects_of(path)) is not None:
            where = f"{OBJECT}/{objects.name}"
            numbers, theirs = distinct(_pixels(read_png(where, read_bytes(objects), size)))
            count, first = len(numbers), int(numbers[0] > 0)
            pairs, place = distinct(place.astype(np.int64) * count + theirs)
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
        """Return whether the colours of an image are of classes, rather than indices in grey."""
        gray = all(value == (value & 255) * GRAY for value in values)
        colors = self.classes.colors
        return not gray or self.classes.by_color or any(v in colors for v in values if v)

    def _of_index(self, value: int, void: int = VOID_8_BIT) -> Key:
        """Return the key of an index: the greatest one says nothing, and 0 is no class, unless they
        have a name."""
        if value in self.names:
            return value, 0
        return NONE if value == 0 else UNKNOWN if value == void else (value, 0)

    def _of_deep(self, values: list[int], name: str) -> list[Key]:
        keys = [self._of_index(value, void=VOID) for value in values]
        met = {key[0] for key in keys} - {NONE[0], UNKNOWN[0]}
        if self.own or met <= self.names.keys():
            return keys
        classes = {each // PER_CLASS if each >= PER_CLASS else each for each in met}
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
        number = self._met.setdefault(color, len(self._met) + 1)
        word = f"#{color:06x}"
        self.names.setdefault(number, ClassName(word, word))
        return number, 0


def _with_object(key: Key, number: int) -> Key:
    """Return the key of a class with the number of an object of one picture, 0 for none."""
    return key if key in (NONE, UNKNOWN) else (key[0], -number)


def _objects_of(path: Path) -> Path | None:
    """Return the file with the objects of a file of classes, or None."""
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
