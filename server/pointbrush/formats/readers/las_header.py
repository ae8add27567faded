"""The header of LAS 1.0 to 1.5 and LAZ, and the fields of a point that exports preserve.

The numbers are from untrusted files: no memory is allocated by them, and no list of records is
read by its stated length.  Fields have laspy's names; fields of a few bits are separate columns.
Layout: ASPRS LAS Specification 1.4 R15.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.options import Limits, require_count

# Bytes of a point, and where its colour is, by point format.
RECORD = (20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67)
COLOR = {2: 20, 3: 28, 5: 28, 7: 30, 8: 30, 10: 30}
EXTRA_TYPES = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8")
COMPRESSED = 0x80
EXTRA_BYTES = (b"LASF_Spec", 4)
"""User and number of the record that describes extra bytes."""
UNDOCUMENTED = "ExtraBytes"
"""Laspy's name for bytes of a record that no field is documented for."""
Array = NDArray[Any]
NO_DATA = 1
"""Bit of the options of extra bytes: the value for no data is set (LAS 1.4, table 24)."""
SCALED = 8
"""Bit of the options of extra bytes: the scale is set."""
SHIFTED = 16
"""Bit of the options of extra bytes: the offset is set."""
MOST_RECORDS = 64 << 20
"""Bytes of the records after the points (EVLRs) that are kept."""
_LEGACY_BYTES = {
    "scan_angle_rank": ("i1", 16), "user_data": ("u1", 17), "point_source_id": ("<u2", 18),
}  # fmt: skip
_BYTES = {
    "classification": ("u1", 16), "user_data": ("u1", 17), "scan_angle": ("<i2", 18),
    "point_source_id": ("<u2", 20), "gps_time": ("<f8", 22),
}  # fmt: skip
_LEGACY_BITS = {
    "return_number": (14, 0, 3), "number_of_returns": (14, 3, 3),
    "scan_direction_flag": (14, 6, 1), "edge_of_flight_line": (14, 7, 1),
    "classification": (15, 0, 5), "synthetic": (15, 5, 1), "key_point": (15, 6, 1),
    "withheld": (15, 7, 1),
}  # fmt: skip
_BITS = {
    "return_number": (14, 0, 4), "number_of_returns": (14, 4, 4), "synthetic": (15, 0, 1),
    "key_point": (15, 1, 1), "withheld": (15, 2, 1), "overlap": (15, 3, 1),
    "scanner_channel": (15, 4, 2), "scan_direction_flag": (15, 6, 1),
    "edge_of_flight_line": (15, 7, 1),
}  # fmt: skip
_WAVE = {
    "wavepacket_index": "u1", "wavepacket_offset": "<u8", "wavepacket_size": "<u4",
    "return_point_wave_location": "<f4", "x_t": "<f4", "y_t": "<f4", "z_t": "<f4",
}  # fmt: skip
_GPS = {1: 20, 3: 20, 4: 20, 5: 20}
_WAVE_AT = {4: 28, 5: 34, 9: 30, 10: 38}
_NIR_AT = {8: 36, 10: 36}
COLORS = ("red", "green", "blue")


@dataclass(frozen=True, slots=True)
class FieldScale:
    """Values of an extra byte: ``stored × scale + offset``; the stored ``no_data`` means none."""

    scale: float = 1.0
    offset: float = 0.0
    no_data: float | None = None

    @property
    def whole(self) -> bool:
        """Whether the values are the stored ones."""
        return self.scale == 1.0 and self.offset == 0.0

    def values(self, stored: Array) -> Array:
        """Return the values of ``stored``, NaN for no data."""
        values = stored * self.scale + self.offset
        if self.no_data is not None:
            values[stored == self.no_data] = np.nan
        return np.asarray(values)


@dataclass(frozen=True, slots=True)
class LasHeader:
    """Parts of the header that are needed to read the points.

    ``offset`` of the first point in bytes; ``scales``, ``offsets``, ``lo``, ``hi`` (3,) float64;
    ``extra`` name → (byte in the record, NumPy type), ``further`` the same of all extra bytes, by
    their own names: parts of tuples as ``name[0]``, undocumented ones as ``ExtraBytes[0]``.
    ``laszip`` is the compressor's record, None for uncompressed points.  ``scalings`` of extra
    bytes, by the names of ``further``.
    """

    version: tuple[int, int]
    point_format: int
    record: int
    offset: int
    count: int
    scales: NDArray[np.float64]
    offsets: NDArray[np.float64]
    lo: NDArray[np.float64]
    hi: NDArray[np.float64]
    extra: dict[str, tuple[int, str]]
    laszip: bytes | None
    further: dict[str, tuple[int, str]] = field(default_factory=dict)
    scalings: dict[str, FieldScale] = field(default_factory=dict)

    @property
    def dtype(self) -> np.dtype[Any]:
        """The fields of a point record that pointbrush reads."""
        fields: dict[str, tuple[str, int]] = {
            "x": ("<i4", 0),
            "y": ("<i4", 4),
            "z": ("<i4", 8),
            "intensity": ("<u2", 12),
        }
        if self.point_format in COLOR:
            at = COLOR[self.point_format]
            fields |= {c: ("<u2", at + 2 * i) for i, c in enumerate(("red", "green", "blue"))}
        for name, (at, kind) in self.extra.items():
            fields.setdefault(name, ("<" + kind, at))
        return np.dtype(
            {
                "names": list(fields),
                "formats": [kind for kind, _ in fields.values()],
                "offsets": [at for _, at in fields.values()],
                "itemsize": self.record,
            }
        )


def read_header(path: Path, limits: Limits) -> LasHeader:
    """The header of a LAS or LAZ file.

    Raises NotFoundError, BadInputError for a damaged header or a file shorter than its points,
    TooLargeError beyond the limits.
    """
    name = path.name
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            start = file.read(375)
            header = _parse(name, start, size)
            header_size = struct.unpack_from("<H", start, 94)[0]
            file.seek(header_size)
            # Records of variable length fill the bytes between header and points, independent of
            # the stated number.  64 MiB is far above real files.
            between = file.read(min(header.offset - header_size, 1 << 26))
    except FileNotFoundError:
        raise NotFoundError(f"{path}: expected a file, it does not exist") from None
    require_count(name, header.count, limits)
    return _with_records(name, header, between, size, start[104])


def _parse(name: str, start: bytes, size: int) -> LasHeader:
    if not start:
        raise BadInputError(f"{name}: expected points, got an empty file (0 bytes)")
    if start[:4] != b"LASF":
        raise BadInputError(f"{name}: expected a LAS file starting with 'LASF', got another")
    if len(start) < 227:
        raise BadInputError(f"{name}: expected a header of 227 bytes or more, got {len(start)}")
    version = (start[24], start[25])
    if version[0] != 1 or version[1] > 5:
        raise BadInputError(f"{name}: expected LAS 1.0 to 1.5, got {version[0]}.{version[1]}")
    header_size, offset = struct.unpack_from("<HI", start, 94)
    form, record, count = struct.unpack_from("<BHI", start, 104)
    # Compressors mark the format in its two upper bits.
    form &= 0x3F
    if form >= len(RECORD):
        raise BadInputError(f"{name}: expected a point format 0 to 10, got {form}")
    if record < RECORD[form]:
        raise BadInputError(
            f"{name}: expected {RECORD[form]} bytes or more for a point of format {form}, got "
            f"{record}"
        )
    if version >= (1, 4) and len(start) >= 255:
        count = struct.unpack_from("<Q", start, 247)[0] or count
    if not 227 <= header_size <= offset <= size:
        raise BadInputError(
            f"{name}: expected points after a header of 227 bytes or more and within {size} bytes, "
            f"got a header of {header_size} and points at {offset}"
        )
    numbers = np.frombuffer(start, "<f8", 12, 131)
    scales, offsets = numbers[:3], numbers[3:6]
    if not np.isfinite(numbers[:6]).all() or not scales.all():
        raise BadInputError(
            f"{name}: expected finite scales and offsets, got {scales.tolist()} and "
            f"{offsets.tolist()}"
        )
    hi, lo = numbers[6::2], numbers[7::2]
    return LasHeader(version, form, record, offset, count, scales, offsets, lo, hi, {}, None)


def _with_records(
    name: str, header: LasHeader, between: bytes, size: int, raw_format: int
) -> LasHeader:
    """Add extra fields and the compressor's record; check the points fit the file."""
    further: dict[str, tuple[int, str]] = {}
    scalings: dict[str, FieldScale] = {}
    laszip: bytes | None = None
    for user, number, data, whole in _records(between):
        if whole and (user, number) == (b"laszip encoded", 22204):
            laszip = data
        elif (user, number) == EXTRA_BYTES:
            further = _extra_fields(data, RECORD[header.point_format], header.record)
            scalings = _scalings(data)
    if raw_format & COMPRESSED and laszip is None:
        raise BadInputError(f"{name}: expected the record of the LAZ compressor, got none")
    needed = header.count * header.record
    if laszip is None and header.offset + needed > size:
        raise BadInputError(
            f"{name}: expected {header.count} points of {header.record} bytes from byte "
            f"{header.offset}, got {size - header.offset} bytes; the file is cut off"
        )
    extra = {name.lower(): place for name, place in further.items() if "[" not in name}
    documented = RECORD[header.point_format]
    for place, kind in further.values():
        documented = max(documented, place + np.dtype(kind).itemsize)
    for byte in range(header.record - documented):
        further[f"{UNDOCUMENTED}[{byte}]"] = (documented + byte, "u1")
    return replace(header, extra=extra, laszip=laszip, further=further, scalings=scalings)


def _records(between: bytes) -> Iterator[tuple[bytes, int, bytes, bool]]:
    """Yield user, number and data of each record of variable length, and whether it is whole."""
    at = 0
    while at + 54 <= len(between):
        user, number, length = struct.unpack_from("<16sHH", between, at + 2)
        data = between[at + 54 : at + 54 + length]
        at += 54 + length
        yield user.split(b"\0")[0], number, data, len(data) == length


def is_las(header: bytes) -> bool:
    """Return whether a source's stored header is of LAS."""
    return header[8:12] == b"LASF"


def scalings_of(records: bytes) -> dict[str, FieldScale]:
    """Return the scalings of extra bytes by a source's header; {} of other formats than LAS."""
    if not is_las(records):
        return {}
    start = split_records(records)[0]
    between = start[struct.unpack_from("<H", start, 94)[0] :]
    for user, number, data, _ in _records(between):
        if (user, number) == EXTRA_BYTES:
            return _scalings(data)
    return {}


def _extra_fields(data: bytes, at: int, record: int) -> dict[str, tuple[int, str]]:
    """Extra bytes by name (LAS 1.4, table 25)."""
    fields: dict[str, tuple[int, str]] = {}
    for start in range(0, len(data) - 191, 192):
        kind, options = data[start + 2], data[start + 3]
        name = data[start + 4 : start + 36].split(b"\0")[0].decode("latin-1")
        scalar = EXTRA_TYPES[(kind - 1) % 10] if 1 <= kind <= 30 else ""
        width = np.dtype(scalar).itemsize * ((kind - 1) // 10 + 1) if scalar else options
        if at + width > record:
            break
        size = np.dtype(scalar).itemsize if scalar else 1
        parts = width // size
        for part in range(parts):
            label = name if kind <= 10 and scalar else f"{name}[{part}]"
            fields[label] = (at + part * size, scalar or "u1")
        at += width
    return fields


def _scalings(data: bytes) -> dict[str, FieldScale]:
    """Scalings of extra bytes that have one or a value for no data (LAS 1.4, table 24)."""
    found: dict[str, FieldScale] = {}
    for start in range(0, len(data) - 191, 192):
        kind, options = data[start + 2], data[start + 3]
        if not 1 <= kind <= 30 or not options & (NO_DATA | SCALED | SHIFTED):
            continue
        name = data[start + 4 : start + 36].split(b"\0")[0].decode("latin-1")
        # The value for no data has 8 bytes for every type of field.
        of_class = f"<{EXTRA_TYPES[(kind - 1) % 10][0]}8"
        for part in range((kind - 1) // 10 + 1):
            none, scale, offset = (
                np.frombuffer(data, form, 1, start + at + 8 * part)[0].item()
                for form, at in ((of_class, 40), ("<f8", 112), ("<f8", 136))
            )
            found[name if kind <= 10 else f"{name}[{part}]"] = FieldScale(
                scale if options & SCALED and np.isfinite(scale) and scale else 1.0,
                offset if options & SHIFTED and np.isfinite(offset) else 0.0,
                none if options & NO_DATA else None,
            )
    return found


def wide(color: str) -> str:
    """Name of the column that keeps a colour's 16 bits."""
    return f"{color}_16"


def further_fields(header: LasHeader, rows: Array) -> dict[str, Array]:
    """Return columns (n,) of point records without a field in a PointFrame, in order."""

    def column(at: int, kind: str) -> Array:
        """Return a contiguous copy of the values ``at`` a byte of each record, for faster reads."""
        place: Any = {
            "names": ["it"],
            "formats": [kind],
            "offsets": [at],
            "itemsize": header.record,
        }
        return np.ascontiguousarray(rows.view(np.dtype(place))["it"])

    legacy = header.point_format < 6
    columns: dict[str, Array] = {}
    flags = {at: column(at, "u1") for at in (14, 15)}
    for name, (at, shift, bits) in (_LEGACY_BITS if legacy else _BITS).items():
        columns[name] = flags[at] >> shift & ((1 << bits) - 1)
    plain = dict(_LEGACY_BYTES if legacy else _BYTES)
    if header.point_format in _GPS:
        plain["gps_time"] = ("<f8", _GPS[header.point_format])
    if header.point_format in _NIR_AT:
        plain["nir"] = ("<u2", _NIR_AT[header.point_format])
    at = _WAVE_AT.get(header.point_format, 0)
    for name, kind in _WAVE.items() if at else ():
        plain[name] = (kind, at)
        at += np.dtype(kind).itemsize
    plain |= {name: (f"<{kind}", at) for name, (at, kind) in header.further.items()}
    for name, (kind, at) in plain.items():
        columns[name] = column(at, kind)
    if "red" in (rows.dtype.names or ()):
        for color in COLORS:
            values = np.ascontiguousarray(rows[color])
            # Colours of 8 bits times 257 follow from the 8 bits; others are kept in full.
            if not np.array_equal(values, (values >> 8) * np.uint16(257)):
                columns[wide(color)] = values
    return columns


def read_records(path: Path, header: LasHeader) -> bytes:
    """Return the file without its points: header and VLRs, then the EVLRs unless they are huge."""
    with path.open("rb") as file:
        start = file.read(header.offset)
        evlrs = b""
        if header.version >= (1, 4) and len(start) >= 247:
            at, count = struct.unpack_from("<QI", start, 235)
            size = path.stat().st_size
            if count and header.offset <= at < size and size - at <= MOST_RECORDS:
                file.seek(at)
                evlrs = file.read()
    return struct.pack("<Q", len(start)) + start + evlrs


def split_records(content: bytes) -> tuple[bytes, bytes]:
    """The two parts of ``read_records``."""
    (length,) = struct.unpack_from("<Q", content)
    return content[8 : 8 + length], content[8 + length :]
