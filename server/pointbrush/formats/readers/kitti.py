"""Float records of KITTI (``.bin``, SemanticKITTI ``.label``), nuScenes, radar and XYZRGB.

A KITTI record is x y z reflectance as float32, or of some writers only x y z; an XYZRGB record is
x y z r g b, colours 0..1 or 0..255: a file without colours above 1 is read as 0..1.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.options import ReadOptions, read_bytes, require_count
from pointbrush.formats.readers.record_width import is_xyz, sample
from pointbrush.formats.readers.unnamed import unnamed
from pointbrush.formats.tables.columns import frame_from_columns
from pointbrush.formats.tables.palette import labels_of_packed, own_palette
from pointbrush.frame import PointFrame
from pointbrush.names import stored_as

RECORD = 16
WIDE = (5, 6, 7)
"""Floats of records with more than KITTI's four."""
MOST_INTENSITY = 65535
"""Greatest plausible value of a wider record's fourth float."""
MOST_RINGS = 512
"""Greatest plausible value of a wider record's fifth float."""
MUCH_LESS = 0.8
"""Greatest ratio of the variance within columns of the right width to that of another width."""
KITTI_FIELDS = ("x", "y", "z", "intensity")
XYZRGB_FIELDS = ("x", "y", "z", "red", "green", "blue")


def read_kitti(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """One ``.bin`` file with its ``.label`` (beside it, or in ``../labels``), if there is one.

    Raises BadInputError for a size that is not whole records, or labels of another count.
    """
    yield _labelled_frame(path, KITTI_FIELDS, options)


def _labelled_frame(path: Path, fields: tuple[str, ...], options: ReadOptions) -> PointFrame:
    columns: dict[str, NDArray[Any]] = {}
    columns |= _table_columns(path.name, read_bytes(path), fields, options)
    label_file = find_label(path)
    if label_file is not None:
        columns["label"], columns["instance"] = read_label(label_file, options)
        count = len(columns["x"])
        if len(columns["label"]) != count:
            raise BadInputError(
                f"{label_file.name}: expected {count} labels of 4 bytes, one for each point, got "
                f"{len(columns['label'])}"
            )
    return frame_from_columns(path.name, columns, options)


def read_bin(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """Read a ``.bin`` file of unknown kind: records of the columns that the user names in order,
    else KITTI, XYZRGB, x y z or wider records, chosen by the values.

    Raises BadInputError when none or several are plausible.
    """
    data = read_bytes(path)
    named = options.chosen.columns
    if named and "=" not in named[0] and len(named) != RECORD // 4:
        fields = tuple(map(str, range(len(named))))
        columns = _table_columns(path.name, data, fields, options)
        yield frame_from_columns(path.name, columns, options)
        return
    wide = [width for width in WIDE if len(data) % (4 * width) == 0 and _is_wide(data, width)]
    colored, label = len(data) % 24 == 0 and _is_xyzrgb(data), find_label(path)
    # A label has 4 bytes, a third of a record of three floats.
    labelled = label is not None and len(data) == 3 * label.stat().st_size
    if labelled or (label is None and not (wide or colored or named) and is_xyz(data)):
        yield _labelled_frame(path, KITTI_FIELDS[:3], options)
        return
    if label is not None or (
        _lies_as_kitti(path) and not wide and len(data) % RECORD == 0 and not _fits_wider(data)
    ):
        yield from read_kitti(path, options)
        return
    # Colours first: other values are hardly ever all within 0..1, or whole, by chance.
    if colored:
        yield from read_xyzrgb(path, options)
    elif len(data) % RECORD == 0 and _is_kitti(data):
        yield from read_kitti(path, options)
    elif len(wide) == 1:
        yield _wide_frame(path, data, wide[0], options)
    else:
        raise BadInputError(
            f"{path.name}: expected records of 4 floats (x y z reflectance), 3 (x y z), 5 to 7 "
            f"(and ring, time, …) or 6 (x y z r g b), got {len(data)} bytes that fit none or "
            "several of these layouts; name the format (kitti, nuscenes or xyzrgb), or all columns "
            "in order"
        )


def read_nuscenes(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """A sweep of nuScenes: x y z intensity ring as float32.

    Raises BadInputError for a size that is not whole records.
    """
    yield _wide_frame(path, read_bytes(path), 5, options)


def _wide_frame(path: Path, data: bytes, width: int, options: ReadOptions) -> PointFrame:
    """x y z intensity ring of records of ``width`` floats; further ones by their column."""
    names = (*KITTI_FIELDS, "ring", *map(unnamed, range(5, width)))
    return frame_from_columns(path.name, _table_columns(path.name, data, names, options), options)


def _table_columns(
    name: str, data: bytes, fields: tuple[str, ...], options: ReadOptions
) -> dict[str, NDArray[np.float32]]:
    """The columns of records of a float32 for each of ``fields``.

    Raises BadInputError for a size that is not whole records, TooLargeError beyond the limit.
    """
    record = 4 * len(fields)
    if len(data) % record:
        raise BadInputError(
            f"{name}: expected records of {record} bytes ({len(fields)} float32), got "
            f"{len(data)} bytes, {len(data) % record} more than {len(data) // record} records"
        )
    require_count(name, len(data) // record, options.limits)
    table = np.frombuffer(data, "<f4").reshape(-1, len(fields))
    return {field: table[:, i] for i, field in enumerate(fields)}


def _lies_as_kitti(path: Path) -> bool:
    """Return whether the folders or a ``.label`` file identify a KITTI scan."""
    folders = {folder.name for folder in path.absolute().parents[:2]}
    return bool(folders & {"velodyne", "velodyne_points"}) or find_label(path) is not None


def _is_kitti(data: bytes) -> bool:
    """Reflectances are 0..1 or 0..255, and some point is further than a metre."""
    table = sample(data, 4)
    magnitude = np.abs(table)
    finite = bool((magnitude < 1e7).all()) and bool((magnitude[:, :3] > 1).any())
    reflectance = table[:, 3]
    return finite and bool((reflectance >= 0).all() and (reflectance <= 255).all())


def _is_wide(data: bytes, width: int) -> bool:
    """Return whether records have coordinates, an intensity, and a ring: an integer in column 5.

    In records of another width, column 5 has coordinates, which are not whole; records of 4 floats
    never pass as wider ones, because then every column has coordinates.
    """
    if len(data) % RECORD == 0 and _is_kitti(data):
        return False
    table = sample(data, width)
    if len(table) < 16 or not (np.abs(table) < 1e10).all():
        return False
    coordinates, intensity, ring = table[:, :3], table[:, 3], table[:, 4]
    moves = bool((np.abs(coordinates) > 1).any() and (coordinates % 1 != 0).mean() > 0.5)
    reflects = bool((intensity >= 0).all() and (intensity <= MOST_INTENSITY).all())
    rings = bool((ring >= 0).all() and (ring <= MOST_RINGS).all() and not np.any(ring % 1))
    return moves and reflects and rings


def _fits_wider(data: bytes) -> bool:
    """Return whether columns vary much less with 5 to 7 floats a record than with four."""

    def spread(width: int) -> float:
        return float(np.arcsinh(np.nan_to_num(sample(data, width))).var(axis=0).mean())

    fitting = [spread(width) for width in WIDE if len(data) % (4 * width) == 0]
    return bool(data) and bool(fitting) and min(fitting) < MUCH_LESS * spread(RECORD // 4)


def _is_xyzrgb(data: bytes) -> bool:
    table = sample(data, 6)
    finite = bool((np.abs(table) < 1e7).all())
    xyz, rgb = table[:, :3], table[:, 3:]
    if not finite or len(table) < 16 or rgb.min() < 0:
        return False
    if rgb.max() <= 1:
        return float(np.mean((xyz < 0) | (xyz > 1))) > 0.1
    return bool(rgb.max() <= 255 and not np.any(rgb % 1))


def find_label(path: Path) -> Path | None:
    """The ``.label`` file that belongs to a ``.bin``, or None."""
    candidates = (path.with_suffix(".label"), path.parent.parent / "labels" / f"{path.stem}.label")
    return next((found for found in map(stored_as, candidates) if found.is_file()), None)


def read_label(path: Path, options: ReadOptions) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
    """Read class (lower 16 bits) and instance (upper 16 bits) of each point.

    Classes of an export of pointbrush are ids of its palette.  Raises BadInputError unless the file
    holds uint32.
    """
    data = read_bytes(path)
    if len(data) % 4:
        raise BadInputError(f"{path.name}: expected labels of 4 bytes, got {len(data)} bytes")
    require_count(path.name, len(data) // 4, options.limits)
    packed, own = np.frombuffer(data, "<u4"), own_palette(path)
    label = packed & 0xFFFF if own is None else labels_of_packed(path.name, packed, own)
    return label.astype(np.uint16), (packed >> 16).astype(np.uint16)


def pack_label(semantic: NDArray[np.uint16], instance: NDArray[np.uint16]) -> NDArray[np.uint32]:
    """SemanticKITTI's uint32: class in the lower 16 bits, instance in the upper 16."""
    packed: NDArray[np.uint32] = semantic.astype("<u4") | instance.astype("<u4") << 16
    return packed


def read_xyzrgb(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """Read x y z red green blue; raises BadInputError for a size that is not whole records."""
    columns = _table_columns(path.name, read_bytes(path), XYZRGB_FIELDS, options)
    yield frame_from_columns(path.name, columns, options)
