"""Rooms of S3DIS: the points of a room, and a file with the points of each object in it.

``ROOM/ROOM.txt`` has lines x y z r g b, ``ROOM/Annotations/CLASS_N.txt`` the lines of an object
(Armeni et al. 2016; Pointcept's ``preprocess_s3dis.py`` reads the same layout).
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.formats.options import ReadOptions
from pointbrush.formats.readers.text import read_text
from pointbrush.formats.tables.label_values import GREATEST_INSTANCE
from pointbrush.formats.tables.numbers import is_number
from pointbrush.formats.times.timing import in_order
from pointbrush.frame import PointFrame

Numbers = NDArray[np.int64]
log = logging.getLogger(__name__)
FOLDER = "Annotations"
HEAD = 512
"""Bytes of a file that are checked for points."""
_OBJECT = re.compile(r"(?P<name>[^\d.].*)_(?P<number>\d{1,9})", re.DOTALL)


@dataclass(frozen=True, slots=True, eq=False)
class Objects:
    """Points of objects: ``xyz`` (M, 3), numbers (M,) of their classes and of their instances."""

    xyz: NDArray[np.float64]
    category: Numbers
    instance: Numbers


def object_files(folder: Path) -> list[Path]:
    """List the files of a folder that have the points of an object each, by number."""
    return in_order([path for path in folder.glob("*.*") if is_object(path)])


def is_object(path: Path) -> bool:
    """Return whether a file is called ``CLASS_N.txt`` and begins with a line of coordinates."""
    if path.suffix.lower() != ".txt" or _OBJECT.fullmatch(path.stem) is None:
        return False
    with path.open("rb") as file:
        words = file.read(HEAD).split(b"\n", 1)[0].decode("ascii", "replace").split()
    return len(words) >= 3 and all(map(is_number, words))


def read_objects(files: Sequence[Path], options: ReadOptions) -> Objects:
    """Read the points of objects; a class has the number that ``options.class_number`` gives.

    Raises BadInputError naming the file.
    """
    found = [_read_object(path, options) for path in files]
    return Objects(
        np.concatenate([each.xyz for each in found]),
        np.concatenate([each.category for each in found]),
        np.concatenate([each.instance for each in found]),
    )


def _read_object(path: Path, options: ReadOptions) -> Objects:
    (frame,) = read_text(path, replace(options, columns_found=None, colors=None))
    match = _OBJECT.fullmatch(path.stem)
    name, number = (match["name"], int(match["number"])) if match else (path.stem, 0)
    category = options.class_number(path.name, name) if options.class_number else 0
    of_point = np.empty(len(frame), np.int64)
    return Objects(
        frame.xyz.astype(np.float64),
        np.full_like(of_point, category),
        np.full_like(of_point, number),
    )


def numbers_at(name: str, xyz: NDArray[np.floating], objects: Objects) -> tuple[Numbers, Numbers]:
    """Return class and instance (N,) of points ``xyz`` (N, 3) that are equal to one of an object.

    They are 0 for other points.  A warning counts points of objects that are not among ``xyz``.
    """
    count = len(xyz)
    both = np.concatenate([xyz, objects.xyz.astype(xyz.dtype)])
    order = np.lexsort(both.T)
    differs = (both[order[1:]] != both[order[:-1]]).any(axis=1)
    place = np.empty(len(both), np.int64)
    place[order] = np.concatenate([[0], np.cumsum(differs)])
    of_place = np.full(len(both), -1, np.int64)
    of_place[place[count:]] = np.arange(len(both) - count)
    which = of_place[place[:count]]
    known = np.zeros(len(both), np.bool_)
    known[place[:count]] = True
    lost = np.count_nonzero(~known[place[count:]])
    if lost:
        log.warning(
            "%s: %d of %d points of objects are not among the points of the room",
            name, lost, len(both) - count,
        )  # fmt: skip
    found = which >= 0
    return np.where(found, objects.category[which], 0), np.where(found, objects.instance[which], 0)


def read_room(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """Read a text of points, with the labels of the objects in ``Annotations`` beside it.

    Raises BadInputError as ``read_text``.
    """
    for frame in read_text(path, options):
        files = object_files(path.parent / FOLDER)
        if not files or options.class_number is None or frame.label is not None:
            yield frame
            continue
        category, instance = numbers_at(path.name, frame.xyz, read_objects(files, options))
        instance[instance > GREATEST_INSTANCE] = 0
        yield replace(frame, label=category.astype(np.uint16), instance=instance.astype(np.uint16))
