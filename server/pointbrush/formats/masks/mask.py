"""Masks of pictures in memory, and masks in files before they are read."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.names import composed
from pointbrush.values.masks import VOID

Size = tuple[int, int]
"""Width and height of a picture, pixels."""
Key = tuple[int, int]
"""Numbers of a class and of an object; the object is 0 for none, negative in one picture alone."""
NONE: Key = (-1, 0)
"""Key of pixels of no class."""
UNKNOWN: Key = (-2, 0)
"""Key of pixels without evidence."""
MOST_PIXELS = 64_000_000
"""Most pixels of a mask."""
MOST_OBJECTS = 60_000
"""Most classes and objects in one mask."""


@dataclass(frozen=True, slots=True, eq=False)
class Mask:
    """A mask of one picture.

    ``place`` (height, width) uint16: 0 for no object, ``VOID``, or the place of the pixel's object
    in ``keys``, counted from 1.
    """

    place: NDArray[np.uint16]
    keys: tuple[Key, ...]

    @classmethod
    def of_keys(cls, file: str, keys: Sequence[Key], place: NDArray[np.integer]) -> Mask:
        """Return a mask from ``place`` (height, width), the place of each pixel's key in ``keys``.

        Keys may repeat, and be NONE or UNKNOWN.  Raises BadInputError for more than
        ``MOST_OBJECTS``.
        """
        known = [key for key in dict.fromkeys(keys) if key not in (NONE, UNKNOWN)]
        if len(known) > MOST_OBJECTS:
            raise BadInputError(
                f"{file}: expected a mask with at most {MOST_OBJECTS:,} objects, got {len(known):,}"
            )
        values = {NONE: 0, UNKNOWN: VOID} | {key: k for k, key in enumerate(known, 1)}
        return cls(np.array([values[key] for key in keys], np.uint16)[place], tuple(known))


def distinct(values: NDArray[np.integer]) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
    """Return the sorted numbers (n,) in an image (height, width), and the place of each pixel's.

    Neighbouring pixels mostly have one number, so that few pixels need to be sorted.
    """
    flat = values.ravel()
    numbers = np.unique(flat[np.r_[True, flat[1:] != flat[:-1]]])
    greatest = int(numbers[-1])
    if greatest > np.iinfo(np.uint16).max:
        return numbers, np.searchsorted(numbers, values)
    table = np.zeros(greatest + 1, np.uint16)
    table[numbers] = np.arange(len(numbers))
    return numbers, table[values]


@dataclass(slots=True, eq=False)
class MaskDrawing:
    """A mask in progress: each shape is drawn over the ones before."""

    size: Size
    keys: list[Key] = field(default_factory=list)
    place: NDArray[np.uint16] = field(init=False)

    def __post_init__(self) -> None:
        self.place = np.zeros(self.size[::-1], np.uint16)

    def draw(self, shape: NDArray[np.bool_], key: Key | None) -> None:
        """Draw the pixels (height, width) of an object; ``key`` None: pixels without evidence.

        Raises ValueError for too many objects.
        """
        if key is None:
            self.place[shape] = VOID
            return
        if key not in self.keys:
            self.keys.append(key)
            if len(self.keys) > MOST_OBJECTS:
                raise ValueError(f"more than {MOST_OBJECTS:,} objects in a picture")
        self.place[shape] = self.keys.index(key) + 1

    def mask(self) -> Mask:
        """Return the mask drawn so far."""
        return Mask(self.place, tuple(self.keys))


@dataclass(frozen=True, slots=True, eq=False)
class MaskFile:
    """The mask of a picture in a file.

    ``name``: path that contains camera and frame; ``read(size)`` returns the mask of a picture of
    this size and raises BadInputError for a mask of another size.  ``frame``: number of the frame,
    which exports of pointbrush state.
    """

    name: str
    read: Callable[[Size], Mask]
    frame: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PictureMask:
    """Labels in a picture for export: ids (height, width), 0 or ``VOID``.

    ``ending``: file name extension of the picture.
    """

    camera: str
    labels: NDArray[np.uint16]
    ending: str = ".png"

    @property
    def folder(self) -> str:
        """Folder of the camera's masks."""
        return folder_of(self.camera)


def folder_of(camera: str) -> str:
    """Return the name of the folder with a camera's masks."""
    return re.sub(r"[^\w.-]+", "_", composed(camera)).strip("._") or "camera"


def require_size(file: str, size: Size, expected: Size) -> None:
    """Raise BadInputError unless a mask has the size of its picture and at most MOST_PIXELS."""
    if size != expected:
        raise BadInputError(
            f"{file}: expected a mask of {expected[0]}x{expected[1]} pixels, the size of the "
            f"camera's pictures, got {size[0]}x{size[1]}"
        )
    if size[0] * size[1] > MOST_PIXELS:
        raise BadInputError(
            f"{file}: expected at most {MOST_PIXELS:,} pixels, got {size[0]}x{size[1]}"
        )
