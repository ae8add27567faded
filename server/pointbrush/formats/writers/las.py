"""LAS 1.4 and LAZ with labels in extra dimensions."""

from __future__ import annotations

import io
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from itertools import count
from typing import Any, BinaryIO

import laspy
import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.readers.las_header import COLORS, UNDOCUMENTED, split_records, wide
from pointbrush.formats.tables.table import Columns, Table, free_name, plain_name, stored_name

# Steps that sources use; coordinates on one of these grids are written exactly.
GRIDS = (1e-2, 1e-3, 1e-4)
EXTRA = ("label", "category", "instance")
TIME = "gps_time"
MOST_NAME = 32
"""Bytes of the name of an extra dimension."""
READ_AS_OURS = ("label", "instance")
"""Extra dimensions that an import reads as labels and instances."""


def write_las_like(out: BinaryIO, table: Table, source: bytes, *, compress: bool) -> None:
    """Write points with the source's version, point format, scale, offset, VLRs and EVLRs, and all
    its fields; ``label``, ``category`` and ``instance`` are extra dimensions.

    ``source``: the result of ``read_records``.  If a field of the source has the name of one of
    ours, it keeps its name, and ours is named ``pointbrush_…``, except ``label`` and ``instance``,
    which the import reads as ours.
    """
    start, after = split_records(source)
    header = laspy.LasHeader.read_from(io.BytesIO(start))
    evlrs = _evlrs(header, after)
    header.vlrs[:] = [vlr for vlr in header.vlrs if not _is_compressor(vlr)]
    if header.version.minor == 0:
        header.version = "1.2"
    undocumented = _register_undocumented(header)
    types, _ = table.opened()
    theirs = set(header.point_format.dimension_names)
    read_as_ours = {name for name in READ_AS_OURS if stored_name(name) not in types}
    ours = {
        name: f"pointbrush_{name}" if name in theirs and name not in read_as_ours else name
        for name in EXTRA
        if name in types
    }
    fresh = [name for name in ours.values() if name not in theirs]
    header.add_extra_dims([laspy.ExtraBytesParams(name, np.uint16) for name in fresh])
    with laspy.open(out, "w", header=header, do_compress=compress, closefd=False) as writer:
        for columns in table.blocks():
            writer.write_points(_like(columns, header, ours, undocumented))
        if evlrs:
            writer.write_evlrs(evlrs)


def _evlrs(header: laspy.LasHeader, after: bytes) -> laspy.vlrs.vlrlist.VLRList | None:
    if not after or header.version.minor < 4:
        return None
    found = laspy.vlrs.vlrlist.VLRList.read_from(
        io.BytesIO(after), header.number_of_evlrs, extended=True
    )
    found[:] = [vlr for vlr in found if not _is_compressor(vlr)]
    return found


def _is_compressor(vlr: laspy.VLR) -> bool:
    """Return whether a record describes the compression of the points, which is written anew."""
    return str(vlr.user_id).strip("\0") in ("laszip encoded", "copc")


def _register_undocumented(header: laspy.LasHeader) -> list[str]:
    """Name undocumented extra bytes, so that ours can follow them."""
    dimensions = header.point_format.dimensions
    found = next((d for d in dimensions if d.name == UNDOCUMENTED), None)
    if found is None:
        return []
    dimensions.remove(found)
    names = [f"extra_byte_{number}" for number in range(found.num_elements)]
    header.add_extra_dims([laspy.ExtraBytesParams(name, np.uint8) for name in names])
    return names


def _like(
    columns: Columns, header: laspy.LasHeader, ours: dict[str, str], undocumented: list[str]
) -> laspy.ScaleAwarePointRecord:
    rows = laspy.ScaleAwarePointRecord.zeros(len(columns["x"]), header=header)
    for axis, scale, offset in zip("xyz", header.scales, header.offsets, strict=True):
        whole = np.rint((np.asarray(columns[axis], np.float64) - offset) / scale)
        rows[axis.upper()] = whole.astype(np.int32)
    if "intensity" in columns:
        rows["intensity"] = columns["intensity"].astype(np.uint16)
    names = set(header.point_format.dimension_names)
    for color in COLORS:
        if color in names and color in columns:
            rows[color] = _colors_of(columns, color)
    _keep_fields(rows, columns, names - set(ours.values()) - {"X", "Y", "Z", "intensity", *COLORS})
    for number, name in enumerate(undocumented):
        byte = _source_column(columns, f"{UNDOCUMENTED}[{number}]")
        if byte is not None:
            rows[name] = byte
    for name, place in ours.items():
        kind = rows[place].dtype
        if columns[name].max(initial=0) > np.iinfo(kind).max:
            raise BadInputError(
                f"{place}: expected numbers that fit {kind} as in the source, got "
                f"{columns[name].max()}"
            )
        rows[place] = columns[name]
    return rows


def _colors_of(columns: Columns, color: str) -> NDArray[np.uint16]:
    found = _source_column(columns, wide(color))
    return columns[color].astype(np.uint16) * 257 if found is None else found


def _keep_fields(
    rows: laspy.ScaleAwarePointRecord, columns: Columns, names: Collection[str]
) -> None:
    """Write the fields ``names`` of the source unchanged."""
    for name in names:
        kept = _source_column(columns, name)
        if kept is None:
            parts = list(_parts(columns, name))
            kept = np.stack(parts, axis=1) if parts else None
        if kept is not None and name in (rows.array.dtype.names or ()):
            rows.array[name] = kept  # stored values: laspy's own fields expect scaled ones
        elif kept is not None:
            rows[name] = kept


def _parts(columns: Columns, name: str) -> Iterator[NDArray[Any]]:
    """The columns of a field of several numbers."""
    for part in count():
        column = _source_column(columns, f"{name}[{part}]")
        if column is None:
            return
        yield column


def _source_column(columns: Columns, name: str) -> NDArray[Any] | None:
    """Return a field of the source by its own name."""
    return columns.get(stored_name(name))


def write_las(out: BinaryIO, table: Table, classes: NDArray[np.uint16], *, compress: bool) -> None:
    """Write columns x y z [red green blue] [intensity] label category instance and further ones.

    Further fields are extra dimensions; ``gps_time`` is a field of LAS.  ``classes``: the ASPRS
    numbers of labels, by id, which are written as classification if they fit (0..255); label,
    category and instance are extra dimensions.  Intensity has 16 bits in LAS: fractions 0..1 are
    scaled to 65535, and other values that do not fit get an additional extra dimension.  ``out``
    must support seek; the table is read three times.
    """
    types, _ = table.opened()
    header = laspy.LasHeader(version="1.4", point_format=7 if "red" in types else 6)
    extent = _Extent.of(table)
    header.offsets, header.scales = extent.offsets, extent.steps(table)
    held = {*"xyz", *COLORS, *(["intensity"] if extent.whole else [])}
    if TIME in types and types[TIME].kind == "f":
        held.add(TIME)
    further = [name for name in types if name not in held]
    fields = _dimensions(further, set(header.point_format.dimension_names))
    header.add_extra_dims(
        [laspy.ExtraBytesParams(place, types[name]) for name, place in fields.items()]
    )
    if TIME in held:
        fields[TIME] = TIME
    with laspy.open(out, "w", header=header, do_compress=compress, closefd=False) as writer:
        for columns in table.blocks():
            rows = _record(columns, header, extent.intensity, classes)
            for name, place in fields.items():
                rows[place] = columns[name]
            writer.write_points(rows)


def _dimensions(names: Iterable[str], theirs: set[str]) -> dict[str, str]:
    """Return the name of each column's extra dimension, at most 32 bytes of ASCII.

    A column with the name of one of LAS's own dimensions gets the prefix ``source_``.
    """
    taken = {name.lower() for name in theirs}
    found: dict[str, str] = {}
    for name in names:
        place = plain_name(name, MOST_NAME)
        if place.lower() in taken:
            place = f"source_{place}"[:MOST_NAME]
        place = free_name(place, taken, MOST_NAME)
        taken.add(place.lower())
        found[name] = place
    return found


def _record(
    columns: Columns,
    header: laspy.LasHeader,
    intensity: float,
    classes: NDArray[np.uint16],
) -> laspy.ScaleAwarePointRecord:
    rows = laspy.ScaleAwarePointRecord.zeros(len(columns["x"]), header=header)
    rows.x, rows.y, rows.z = (np.asarray(columns[axis], np.float64) for axis in "xyz")
    if "red" in columns:
        for color in ("red", "green", "blue"):
            # 8 bits to 16: 255 becomes 65535.
            setattr(rows, color, columns[color].astype(np.uint16) * 257)
    if "intensity" in columns:
        scaled = np.rint(columns["intensity"].astype(np.float64) * intensity)
        rows.intensity = np.clip(scaled, 0, 65535).astype(np.uint16)
    if "label" in columns:
        category = classes[columns["label"]]
        rows.classification = np.where(category < 256, category, 0).astype(np.uint8)
    return rows


@dataclass(frozen=True, slots=True, eq=False)
class _Extent:
    """Bounds (3,) of all points, and the factor that makes their intensities 16 bits.

    ``whole``: intensities are whole numbers of 16 bits.
    """

    lo: NDArray[np.float64]
    hi: NDArray[np.float64]
    intensity: float
    whole: bool

    @classmethod
    def of(cls, table: Table) -> _Extent:
        lo, hi = np.full(3, np.inf), np.full(3, -np.inf)
        least, greatest, fractions = 0.0, 0.0, False
        for columns in table.blocks():
            if len(columns["x"]) == 0:
                continue
            lo = np.minimum(lo, [float(columns[axis].min()) for axis in "xyz"])
            hi = np.maximum(hi, [float(columns[axis].max()) for axis in "xyz"])
            if "intensity" in columns:
                least = min(least, float(columns["intensity"].min()))
                greatest = max(greatest, float(columns["intensity"].max()))
                fractions = fractions or bool(np.any(columns["intensity"] % 1))
        if not np.isfinite(lo).all():
            lo = hi = np.zeros(3)
        whole = least >= 0 and greatest <= 65535 and not fractions
        return cls(lo, hi, 65535.0 if 0 < greatest <= 1 and fractions else 1.0, whole)

    @property
    def offsets(self) -> NDArray[np.float64]:
        """Whole units below all points."""
        return np.floor(self.lo)

    def steps(self, table: Table) -> NDArray[np.float64]:
        """Return per axis the coarsest usual grid of all points, or the finest that int32 spans."""
        fits = {(axis, step): True for axis in range(3) for step in GRIDS}
        for columns in table.blocks():
            for (axis, step), fit in fits.items():
                if fit:
                    counts = (columns["xyz"[axis]].astype(np.float64) - self.offsets[axis]) / step
                    fits[axis, step] = bool(np.all(np.abs(counts - np.rint(counts)) < 1e-4))
        span = self.hi - self.lo + 1.0
        usable = {key for key, fit in fits.items() if fit and span[key[0]] / key[1] < 2**31 - 1}
        finest = 10.0 ** np.ceil(np.log10(span / (2**31 - 2)))
        return np.array(
            [next((s for s in GRIDS if (axis, s) in usable), finest[axis]) for axis in range(3)]
        )
